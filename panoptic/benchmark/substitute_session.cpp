// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/substitute_session.h"

#include <algorithm>
#include <map>
#include <utility>

#include "panoptic/base/error.h"
#include "panoptic/fusion/reference_labels.h"

namespace panoptic {
namespace {

// The true thing that most pixels of each segment show; 0 where most show none.
std::vector<std::uint16_t> majority_instances(const RegisteredFrame& registered, std::size_t segment_count,
                                              const Image<std::uint16_t>& true_instance) {
  std::vector<std::map<std::uint16_t, std::size_t>> counts(segment_count);
  for (std::size_t i = 0; i < registered.pixel_count(); ++i) {
    const std::uint16_t segment = registered.segment[i];
    if (segment != 0 && segment != RegisteredFrame::kNoSegment) ++counts[segment - 1U][true_instance[i]];
  }
  std::vector<std::uint16_t> result(segment_count, 0);
  for (std::size_t s = 0; s < segment_count; ++s) {
    const auto most = std::ranges::max_element(counts[s], {}, [](const auto& entry) { return entry.second; });
    if (most != counts[s].end()) result[s] = most->first;
  }
  return result;
}

}  // namespace

SubstituteSession::SubstituteSession(const Options& options, LabelSet labels, Substitutes substitutes)
    : substitutes_(substitutes),
      map_(options.map, std::move(labels)),
      registration_(options.depth),
      tracker_(options.tracker, map_.labels),
      integrator_(options.integrator, map_.voxels, map_.labels.first_thing()),
      mesher_(options.mesher),
      votes_(map_.voxels.voxel_size_m()) {}

void SubstituteSession::add(const Frame& frame, const Segmentation& segmentation, const Image<std::uint16_t>& true_instance) {
  PANOPTIC_ASSERT(true_instance.same_size(frame.depth.width(), frame.depth.height()));
  // No slot is given anew: votes_ may name any.
  if (map_.objects.wants_retirement()) map_.prune(std::vector<bool>(kLabelSlots, true));
  const RegisteredFrame& registered = registration_.apply(frame, segmentation);
  if (registered.readings == 0) return;
  const std::vector<LabelSlot>* ids = nullptr;
  if (substitutes_.tracking) {
    ids = &assign_truth(registered, segmentation.segments, true_instance, frame.index);
  } else {
    reference_labels(map_.voxels, frame, registered, reference_);
    ids = &tracker_.assign(registered, segmentation.segments, reference_, frame.index, map_.objects);
  }
  integrator_.integrate(frame, registered, *ids, map_.voxels);
  if (substitutes_.storage) votes_.add(frame, registered, *ids);
}

const std::vector<LabelSlot>& SubstituteSession::assign_truth(const RegisteredFrame& registered,
                                                              std::span<const Segment> segments,
                                                              const Image<std::uint16_t>& true_instance, std::int64_t frame) {
  const auto instances = majority_instances(registered, segments.size(), true_instance);
  std::vector<LabelSlot> id_of(segments.size(), LabelSlot::kUnknown);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    if (map_.labels.is_stuff(segments[s].class_id)) {
      id_of[s] = LabelSet::of_class(segments[s].class_id);
    } else if (instances[s] != 0) {
      id_of[s] = object_of(instances[s]);
      if (id_of[s] != LabelSlot::kUnknown) map_.objects.observe(id_of[s], segments[s], frame);
    }
  }
  assigned_.assign(registered.segment.size(), LabelSlot::kNoVote);
  for (std::size_t i = 0; i < registered.pixel_count(); ++i) {
    const std::uint16_t segment = registered.segment[i];
    if (segment == RegisteredFrame::kNoSegment) continue;
    assigned_[i] = segment == 0 ? LabelSlot::kUnknown : id_of[segment - 1U];
  }
  return assigned_;
}

LabelSlot SubstituteSession::object_of(std::uint16_t true_instance) {
  const auto [entry, is_new] = object_of_instance_.try_emplace(true_instance, LabelSlot::kUnknown);
  if (is_new || map_.objects.find(entry->second) == nullptr) entry->second = map_.objects.create().value_or(LabelSlot::kUnknown);
  return entry->second;
}

Mesh SubstituteSession::mesh() {
  mesher_.update(map_);
  Mesh mesh = mesher_.assemble(map_);
  if (!substitutes_.storage) return mesh;
  for (MeshVertex& vertex : mesh.vertices) {
    const std::optional<LabelSlot> winner = votes_.winner(vertex.position);
    if (!winner) continue;
    vertex.panoptic_id = map_.objects.id_of(*winner);
    vertex.class_id = map_.class_of(*winner);
  }
  return mesh;
}

}  // namespace panoptic
