// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/publisher.h"

#include <algorithm>
#include <map>
#include <utility>

#include "panoptic/frame_statistics.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

// Every living object; those without surface fall out when it is measured.
std::vector<SnapshotObject> objects_of(const Mapper& mapper) {
  std::vector<SnapshotObject> objects;
  const ObjectRegistry& registry = mapper.map().objects;
  for (const Object& object : registry.state().objects) {
    if (object.id == PanopticId::kUnknown) continue;
    SnapshotObject& o = objects.emplace_back();
    o.id = object.id;
    o.class_id = registry.class_of(object.slot);
    o.probabilities = registry.probabilities(object.slot);
    o.first_frame = object.first_frame;
    o.last_frame = object.last_frame;
    o.observations = object.observations;
  }
  std::ranges::sort(objects, {}, &SnapshotObject::id);  // slots may have been given anew
  return objects;
}

SnapshotFrame frame_of(const std::shared_ptr<const Frame>& frame) {
  SnapshotFrame result;
  if (frame == nullptr) return result;
  result.index = frame->index;
  result.time_s = frame->time_s;
  result.color_camera = frame->color_camera;
  result.world_from_color = frame->world_from_camera * frame->color_from_depth.inverse();
  result.color = {frame, &frame->color};
  return result;
}

void show_labels(const LabelledFrame& labelled, SnapshotFrame& frame) {
  frame.labelled_index = labelled.frame->index;
  frame.labelled_color = {labelled.frame, &labelled.frame->color};
  const Image<std::uint16_t>& segment_at = labelled.segmentation->segment_at;
  Image<PanopticId> ids(segment_at.width(), segment_at.height());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const std::uint16_t segment = segment_at[i];
    const bool known = segment > 0 && segment <= labelled.segment_ids.size();
    ids[i] = known ? labelled.segment_ids[segment - 1U] : PanopticId::kUnknown;
  }
  frame.labelled_ids = std::make_shared<const Image<PanopticId>>(std::move(ids));
}

}  // namespace

void CameraPath::add(const Vec3f& place_m) {
  newest_ = place_m;
  if (seen_++ % every_ != 0) return;
  kept_.push_back(place_m);
  if (kept_.size() + 1 < kMaxPathPoints) return;
  for (std::size_t i = 0; 2 * i < kept_.size(); ++i) kept_[i] = kept_[2 * i];
  kept_.resize((kept_.size() + 1) / 2);
  every_ *= 2;
}

std::vector<Vec3f> CameraPath::points() const {
  std::vector<Vec3f> points = kept_;
  if (seen_ > 0 && points.back() != newest_) points.push_back(newest_);
  return points;
}

void SnapshotPublisher::fused(std::shared_ptr<const Frame> frame) {
  newest_ = std::move(frame);
  path_.add(newest_->world_from_camera.translation().cast<float>());
}

// Where the camera was, as far as it was corrected since the last time.
void SnapshotPublisher::follow_poses(const MapperParts& mapper) {
  if (std::exchange(times_anew_, mapper.times_anew()) == mapper.times_anew()) return;
  path_ = {};
  for (const FrameLog::Entry& entry : mapper.log().entries()) path_.add(entry.world_from_camera.translation().cast<float>());
  const auto newest = newest_ != nullptr ? mapper.log().find(newest_->index) : std::nullopt;
  if (!newest) return;
  Frame moved = *newest_;
  moved.world_from_camera = mapper.log().entries()[*newest].world_from_camera;
  newest_ = std::make_shared<const Frame>(std::move(moved));
}

MapCapture SnapshotPublisher::capture(Mapper& mapper, RunState run) {
  MapCapture capture;
  follow_poses(mapper.parts());
  const auto& surface = mapper.parts().surface();
  for (Slot slot = 0; slot < surface.size(); ++slot)
    capture.chunks.push_back({mapper.map().voxels.index_of(slot), 0, surface[slot]});
  capture.objects = objects_of(mapper);
  capture.path_m = path_.points();
  capture.up = mapper.up().cast<float>();
  capture.frame = frame_of(newest_);
  capture.labelled = labelled_;
  if (capture.labelled) {
    for (PanopticId& id : capture.labelled->segment_ids) id = mapper.map().objects.survivor(id);
  }
  run.frames_used = mapper.frames().used();
  run.frames_labelled = mapper.labelled();
  for (const auto& [name, histogram] : mapper.profile().stages()) run.stages[name] = stage_time(histogram);
  run.memory_mb = rss_mb();
  capture.run = std::move(run);
  return capture;
}

std::vector<SnapshotPublisher::ObjectPart> SnapshotPublisher::parts_of(const MeshChunk& chunk) {
  std::vector<ObjectPart> parts;
  for (const ChunkVertex& v : chunk.vertices) {
    auto part = std::ranges::find(parts, v.panoptic_id, &ObjectPart::id);
    if (part == parts.end()) part = parts.insert(parts.end(), {v.panoptic_id, 0, v.position, v.position});
    ++part->vertices;
    part->min_m = part->min_m.cwiseMin(v.position);
    part->max_m = part->max_m.cwiseMax(v.position);
  }
  return parts;
}

void SnapshotPublisher::take_up_chunks(const MapCapture& capture, Snapshot& snapshot) {
  static const auto kNothing = std::make_shared<const MeshChunk>();
  // A map that was made anew may have fewer; whoever looks on must hear that the others are empty.
  chunks_.resize(std::max(chunks_.size(), capture.chunks.size()));
  parts_.resize(chunks_.size());
  for (std::size_t slot = 0; slot < chunks_.size(); ++slot) {
    const bool is_there = slot < capture.chunks.size();
    const SnapshotChunk now = is_there ? capture.chunks[slot] : SnapshotChunk{chunks_[slot].index, 0, kNothing};
    if (chunks_[slot].surface == now.surface) continue;
    chunks_[slot] = {now.index, snapshot.revision, now.surface};
    parts_[slot] = parts_of(*now.surface);
  }
  snapshot.chunks = chunks_;
}

void SnapshotPublisher::measure_objects(MapCapture& capture, Snapshot& snapshot) const {
  std::map<PanopticId, ObjectPart> whole;
  for (const std::vector<ObjectPart>& parts : parts_) {
    for (const ObjectPart& part : parts) {
      ObjectPart& object = whole.try_emplace(part.id, ObjectPart{part.id, 0, part.min_m, part.max_m}).first->second;
      object.vertices += part.vertices;
      object.min_m = object.min_m.cwiseMin(part.min_m);
      object.max_m = object.max_m.cwiseMax(part.max_m);
    }
  }
  for (SnapshotObject& object : capture.objects) {
    const auto surface = whole.find(object.id);
    if (surface == whole.end()) continue;
    object.vertices = surface->second.vertices;
    object.min_m = surface->second.min_m;
    object.max_m = surface->second.max_m;
    snapshot.objects.push_back(std::move(object));
  }
}

void SnapshotPublisher::publish(MapCapture capture) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->revision = ++revision_;
  take_up_chunks(capture, *snapshot);
  measure_objects(capture, *snapshot);
  snapshot->path_m = std::move(capture.path_m);
  snapshot->up = capture.up;
  snapshot->frame = std::move(capture.frame);
  if (capture.labelled) show_labels(*capture.labelled, snapshot->frame);
  snapshot->run = std::move(capture.run);
  latest_.publish(std::move(snapshot));
}

StageTime stage_time(const DurationHistogram& times) {
  return {times.count(), times.percentile_ms(0.5), times.percentile_ms(0.95), times.last_ms()};
}

SnapshotScene scene_of(const Mapper& mapper, std::string title, std::string dataset) {
  return {std::move(title), std::move(dataset), mapper.map().labels, mapper.map().voxels.voxel_size_m(),
          mapper.map().voxels.block_size_m()};
}

}  // namespace panoptic
