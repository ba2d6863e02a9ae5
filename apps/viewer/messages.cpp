// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "panoptic/base/json.h"
#include "panoptic/data/label_json.h"

namespace panoptic {
namespace {

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

// Rounds to a tenth of a millimetre: floats as JSON writes them in full are three times as long.
double rounded(double value) { return std::round(value * 1e4) / 1e4; }

Json to_json(const Vec3f& v) { return {rounded(v.x()), rounded(v.y()), rounded(v.z())}; }

std::string key(BlockIndex i) { return fmt::format("{},{},{}", i.x, i.y, i.z); }

Json path_json(const std::vector<Vec3f>& path) {
  Json points = Json::array();
  const std::size_t stride = std::max<std::size_t>(1, (path.size() + kMaxPathSent - 2) / (kMaxPathSent - 1));
  for (std::size_t i = 0; i < path.size(); i += stride) points.push_back(to_json(path[i]));
  if (!path.empty() && (path.size() - 1) % stride != 0) points.push_back(to_json(path.back()));
  return points;
}

Json frame_json(const SnapshotFrame& frame) {
  if (frame.index < 0) return nullptr;
  Json pose = Json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) pose.push_back(frame.world_from_color.matrix()(row, column));
  }
  const Camera& c = frame.color_camera;
  return {{"index", frame.index},
          {"time_s", frame.time_s},
          {"labelled_index", frame.labelled_index},
          {"world_from_camera", std::move(pose)},
          {"camera", {{"width", c.width}, {"height", c.height}, {"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx}, {"cy", c.cy}}}};
}

Json run_json(const RunState& run) {
  Json stages = Json::object();
  for (const auto& [name, s] : run.stages) {
    stages[name] = {{"count", s.count}, {"p50_ms", s.p50_ms}, {"p95_ms", s.p95_ms}, {"last_ms", s.last_ms}};
  }
  return {{"frames_done", run.frames_done}, {"frames_total", run.frames_total},
          {"frames_used", run.frames_used}, {"frames_labelled", run.frames_labelled},
          {"dropped", run.dropped},         {"geometry_hz", run.geometry_hz},
          {"label_hz", run.label_hz},       {"elapsed_s", run.elapsed_s},
          {"memory_mb", run.memory_mb},     {"finished", run.finished},
          {"stopped_by", run.stopped_by},   {"stages", std::move(stages)}};
}

Json to_json(const SnapshotObject& object, const LabelSet& labels) {
  Json probabilities = Json::array();
  for (const ClassProbability& p : object.probabilities) {
    probabilities.push_back(Json::array({number(p.class_id), p.probability}));
  }
  std::string name(labels.name_of(object.class_id));
  std::replace(name.begin(), name.end(), ' ', '_');
  return {{"id", number(object.id)},
          {"class_id", number(object.class_id)},
          {"name", fmt::format("{}_{}", name, number(object.id))},
          {"color", color_json(color_of(object.id, labels))},
          {"probabilities", std::move(probabilities)},
          {"first_frame", object.first_frame},
          {"last_frame", object.last_frame},
          {"observations", object.observations},
          {"vertices", object.vertices},
          {"min_m", to_json(object.min_m)},
          {"max_m", to_json(object.max_m)}};
}

Json id_or_null(PanopticId id) { return id == PanopticId::kUnknown ? Json(nullptr) : Json(number(id)); }

Json to_json(const ObjectSpan& span, const LabelSet& labels) {
  return {{"id", number(span.id)},
          {"class_id", number(span.class_id)},
          {"color", color_json(color_of(span.id, labels))},
          {"min_m", to_json(Vec3f(span.box.min_m.cast<float>()))},
          {"max_m", to_json(Vec3f(span.box.max_m.cast<float>()))},
          {"first_s", span.first_s},
          {"gone_s", span.gone_s ? Json(*span.gone_s) : Json(nullptr)},
          {"appeared", span.appeared},
          {"moved_from", id_or_null(span.moved_from)},
          {"moved_to", id_or_null(span.moved_to)}};
}

// Every `stride`-th box, the first and the last, as time, lowest corner, highest corner in one row of numbers.
Json to_json(const MovingTrack& track, std::size_t stride) {
  Json boxes = Json::array();
  for (std::size_t i = 0; i < track.boxes.size(); ++i) {
    if (i % stride != 0 && i + 1 != track.boxes.size()) continue;
    const TrackedBox& box = track.boxes[i];
    boxes.push_back(rounded(box.time_s));
    for (const Vec3d& corner : {box.min_m, box.max_m}) {
      for (const double c : {corner.x(), corner.y(), corner.z()}) boxes.push_back(rounded(c));
    }
  }
  return {{"id", track.id}, {"class_id", number(track.class_id)}, {"boxes", std::move(boxes)}};
}

// The longest ones, in their order.
std::vector<const MovingTrack*> tracks_to_send(const std::vector<MovingTrack>& tracks) {
  std::vector<const MovingTrack*> some;
  for (const MovingTrack& track : tracks) some.push_back(&track);
  if (some.size() <= kMaxTracksSent) return some;
  std::ranges::stable_sort(some, std::ranges::greater(), [](const MovingTrack* t) { return t->boxes.size(); });
  some.resize(kMaxTracksSent);
  std::ranges::sort(some, {}, &MovingTrack::id);
  return some;
}

}  // namespace

std::string scene_message(const SnapshotScene& scene, const SceneFacts& facts) {
  return text_of({{"protocol", kViewerProtocol},
                  {"title", scene.title},
                  {"dataset", scene.dataset},
                  {"run", facts.run},
                  {"voxel_size_m", scene.voxel_size_m},
                  {"block_size_m", scene.block_size_m},
                  {"first_thing", scene.labels.first_thing()},
                  {"has_confidence", scene.has_confidence},
                  {"has_history", facts.has_history},
                  {"grows", facts.grows},
                  {"classes", classes_json(scene.labels)}});
}

std::string state_message(const SnapshotSurface& surface, std::uint64_t since) {
  const Snapshot& snapshot = surface.snapshot();
  Json chunks = Json::array();
  for (std::size_t i = 0; i < snapshot.chunks.size(); ++i) {
    const bool is_empty = snapshot.chunks[i].surface->triangles.empty();
    if (is_empty && since == 0) continue;  // whoever has nothing need not hear of it
    if (surface.version(i) > since) chunks.push_back(Json::array({key(snapshot.chunks[i].index), surface.version(i)}));
  }
  return text_of({{"revision", snapshot.revision},
                  {"up", to_json(snapshot.up)},
                  {"chunks", std::move(chunks)},
                  {"path", path_json(snapshot.path_m)},
                  {"frame", frame_json(snapshot.frame)},
                  {"run", run_json(snapshot.run)}});
}

std::string objects_message(const Snapshot& snapshot, const LabelSet& labels) {
  Json objects = Json::array();
  for (const SnapshotObject& object : snapshot.objects) objects.push_back(to_json(object, labels));
  return text_of({{"revision", snapshot.revision}, {"objects", std::move(objects)}});
}

std::string history_message(const SceneHistory& history, const LabelSet& labels) {
  constexpr std::size_t kNumbersOfBox = 7;
  Json objects = Json::array();
  const std::size_t spans = std::min(history.spans.size(), kMaxSpansSent);
  for (std::size_t i = 0; i < spans; ++i) objects.push_back(to_json(history.spans[i], labels));
  const std::vector<const MovingTrack*> some = tracks_to_send(history.tracks);
  std::size_t boxes = 0;
  for (const MovingTrack* track : some) boxes += track->boxes.size();
  // The first and the last box of a track come besides those that are `stride` apart.
  const std::size_t room = kMaxTrackedBoxesSent - 2 * some.size();
  const std::size_t stride = boxes <= kMaxTrackedBoxesSent ? 1 : (boxes + room - 1) / room;
  Json tracks = Json::array();
  std::size_t sent = 0;
  for (const MovingTrack* track : some) {
    tracks.push_back(to_json(*track, stride));
    sent += tracks.back()["boxes"].size() / kNumbersOfBox;
  }
  return text_of({{"start_s", history.start_s},
                  {"end_s", history.end_s},
                  {"objects", std::move(objects)},
                  {"tracks", std::move(tracks)},
                  {"left_out",
                   {{"objects", history.spans.size() - spans},
                    {"tracks", history.tracks.size() - some.size()},
                    {"boxes", boxes - sent},
                    {"forgotten_boxes", history.forgotten_boxes}}}});
}

std::string event_message(const Snapshot& snapshot, const std::string& run) {
  return text_of(
      {{"revision", snapshot.revision}, {"frame", snapshot.frame.index}, {"finished", snapshot.run.finished}, {"run", run}});
}

}  // namespace panoptic
