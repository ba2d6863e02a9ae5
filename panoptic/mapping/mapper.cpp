// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapper.h"

#include <utility>

#include "panoptic/frame_statistics.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/profile.h"

namespace panoptic {

Mapper::Mapper(const Options& options, LabelSet labels) : parts_(std::make_unique<MapperParts>(options, std::move(labels))) {}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;

Outcome Mapper::add(const Frame& frame, const Segmentation& segmentation) { return parts_->add(frame, segmentation); }
Outcome Mapper::add_geometry(const Frame& frame) { return parts_->add_geometry(frame); }
Outcome Mapper::add_labels(const Frame& frame, const Segmentation& segmentation) {
  return parts_->add_labels(frame, segmentation);
}
void Mapper::skip(const SkippedFrame& frame) { parts_->skip(frame); }
void Mapper::regularize() { parts_->regularize(); }
void Mapper::finish() { parts_->finish(); }
Correction Mapper::update_poses(std::span<const PoseUpdate> poses, const ReadFrame& read) {
  return parts_->update_poses(poses, read);
}
Mesh Mapper::mesh() { return parts_->mesh(); }
const PanopticMap& Mapper::map() const { return parts_->map(); }
const FrameStatistics& Mapper::frames() const { return parts_->frames(); }
std::uint64_t Mapper::labelled() const { return parts_->labelled(); }
std::vector<PanopticId> Mapper::segment_ids() const { return parts_->segment_ids(); }
std::vector<MovingTrack> Mapper::moving_tracks() const { return parts_->moving_tracks().tracks(); }
Profile& Mapper::profile() { return parts_->profile(); }
const Profile& Mapper::profile() const { return std::as_const(*parts_).profile(); }
Vec3d Mapper::up() const { return parts_->up(); }

}  // namespace panoptic
