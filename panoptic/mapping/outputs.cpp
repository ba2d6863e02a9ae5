// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <type_traits>

#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/base/memory.h"
#include "panoptic/base/version.h"
#include "panoptic/data/label_json.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/io/recording_list.h"
#include "panoptic/io/views.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/mapping/tracking_outputs.h"
#include "panoptic/mesh.h"
#include "panoptic/outputs.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

Json to_json(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

Json to_json(const DurationHistogram& h) {
  return {{"count", h.count()},
          {"mean_ms", h.mean_ms()},
          {"p50_ms", h.percentile_ms(0.5)},
          {"p95_ms", h.percentile_ms(0.95)},
          {"max_ms", h.max_ms()}};
}

Json value_json(const Field& field) {
  return std::visit(
      [](const auto& value) -> Json {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, AppendTable>) {
          return nullptr;
        } else if constexpr (std::is_same_v<T, std::optional<double>*>) {
          return value->has_value() ? Json(**value) : Json(nullptr);
        } else {
          return *value;
        }
      },
      field.value);
}

Json to_json(const Fields& fields) {
  Json json = Json::object();
  for (const Field& field : fields) {
    Json* place = &json;
    std::string key = field.key;
    for (std::size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.')) {
      place = &(*place)[key.substr(0, dot)];
      key = key.substr(dot + 1);
    }
    (*place)[key] = value_json(field);
  }
  return json;
}

Json to_json(const FrameStatistics& frames) {
  Json list = Json::array();
  for (const SkippedFrame& f : frames.first_skipped()) list.push_back({{"index", f.index}, {"reason", f.reason}});
  return {{"used", frames.used()},
          {"skipped", frames.skipped()},
          {"skipped_by_reason", frames.skipped_by_reason()},
          {"skipped_frames", std::move(list)}};
}

Json to_json(const Profile& profile) {
  Json stages = Json::object();
  for (const auto& [name, histogram] : profile.stages()) stages[name] = to_json(histogram);
  return stages;
}

Json to_json(const OnlineReport& o) {
  return {{"read", o.read},
          {"used", o.used},
          {"skipped", o.skipped},
          {"dropped", o.dropped},
          {"lost", o.lost},
          {"labelled", o.labelled},
          {"passed_over", o.passed_over},
          {"geometry_hz", o.geometry_hz},
          {"label_hz", o.label_hz},
          {"latency", to_json(o.latency)}};
}

Json to_json(const Correction& c) {
  Json json = {{"frames", c.frames},   {"blocks_refused", c.blocks_refused},
               {"blocks", c.blocks},   {"ms", c.ms},
               {"wait_ms", c.wait_ms}, {"pause_ms", c.pause_ms}};
  if (c.unknown > 0) json["unknown"] = {{"frames", c.unknown}, {"first", c.first_unknown}};
  return json;
}

Json to_json(const RunRecording& r) {
  const auto path = [](const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); };
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = r.world_from_recording.linear();
  return {{"recording", r.recording},
          {"calibration", path(r.calibration)},
          {"predictions", path(r.predictions)},
          {"rotation", std::vector<double>(rotation.data(), rotation.data() + rotation.size())},
          {"translation", to_json(Vec3d(r.world_from_recording.translation()))},
          {"first_frame", r.first_number},
          {"frames", r.frames}};
}

Json to_json(const OrientedBox& box) {
  Json axes = Json::array();
  for (int a = 0; a < 3; ++a) axes.push_back(to_json(Vec3d(box.axes.col(a))));
  return {{"center_m", to_json(box.center_m)}, {"axes", std::move(axes)}, {"size_m", to_json(box.size_m)}};
}

Json to_json(const VoteHistory& votes, const LabelSet& labels) {
  Json bins = Json::array();
  for (const VoteHistory::Bin& bin : votes.bins()) {
    Json classes = Json::object();
    for (const auto& [class_id, count] : bin.votes) classes[std::string(labels.name_of(class_id))] = count;
    bins.push_back({{"first_frame", votes.first_frame(bin)}, {"classes", std::move(classes)}});
  }
  return {{"frames_per_bin", votes.frames_per_bin()}, {"bins", std::move(bins)}};
}

Json to_json(const BestViews& best, const LabelSet& labels) {
  Json views = Json::array();
  for (const ObjectView& view : best.views()) {
    views.push_back({{"frame", view.frame},
                     {"class", labels.name_of(view.class_id)},
                     {"score", view.score},
                     {"visible_px", view.visible_px},
                     {"box_px", {view.box.u0, view.box.v0, view.box.u1, view.box.v1}}});
  }
  return views;
}

// The changes that object maintenance made to an object, in words.
Json history_json(const Object& object, ClassId class_id, const LabelSet& labels) {
  Json history = Json::array();
  if (object.observations == 0) {
    history.push_back(fmt::format("after frame {}: found by its shape, no mask ever told it apart", object.first_frame));
  }
  const std::uint64_t earlier = object.parts.count() - object.parts.latest().size();
  if (earlier > 0) history.push_back(fmt::format("{} other objects were joined with it earlier, parts of it", earlier));
  for (const ObjectPart& part : object.parts.latest()) {
    history.push_back(fmt::format("after frame {}: joined with object {}, a part of it", part.frame, number(part.id)));
  }
  const auto own = object.evidence.find(class_id);
  const double least = own == object.evidence.end() ? 0 : own->second;
  for (const ClassId ruled_out : object.ruled_out) {
    const auto found = object.evidence.find(ruled_out);
    if (found == object.evidence.end() || found->second <= least) continue;
    history.push_back(fmt::format("at the end: too large to be a {}", labels.name_of(ruled_out)));
  }
  return history;
}

// When an object was there (objects.json): its state, and times in seconds of the recording.
void add_presence(const Object& object, const Mapper& mapper, Json& json) {
  const auto& arrivals = mapper.map().history.arrivals;
  const auto arrival = arrivals.find(object.id);
  const bool was_moved = arrival != arrivals.end() && arrival->second.moved_from != PanopticId::kUnknown;
  json["state"] = "present";
  json["first_time"] = mapper.frames().time_of(object.first_frame);
  json["last_time"] = mapper.frames().time_of(object.last_frame);
  json["gone_time"] = nullptr;
  json["appeared"] = arrival != arrivals.end();
  json["moved_from"] = was_moved ? Json(number(arrival->second.moved_from)) : Json(nullptr);
  json["moved_to"] = nullptr;
  if (was_moved) json["moved_confidence"] = arrival->second.confidence;
}

OrientedBox upright_box(const ExtentBox& box) {
  return {.center_m = (box.min_m + box.max_m) / 2, .axes = Eigen::Matrix3d::Identity(), .size_m = box.max_m - box.min_m};
}

Json to_json(const PastObject& past, const Mapper& mapper) {
  const std::string class_name(mapper.map().labels.name_of(past.class_id));
  const bool is_moved = past.moved_to != PanopticId::kUnknown;
  return {{"id", number(past.id)},
          {"class_id", number(past.class_id)},
          {"class", class_name},
          {"probabilities", {{class_name, past.probability}}},
          {"box", {{"min_m", to_json(past.box.min_m)}, {"max_m", to_json(past.box.max_m)}}},
          {"oriented_box", to_json(upright_box(past.box))},
          {"centroid_m", to_json(past.box.center_m)},
          {"surface_area_m2", 0},
          {"vertices", 0},
          {"first_frame", past.first_frame},
          {"last_frame", past.last_frame},
          {"observations", past.observations},
          {"state", is_moved ? "moved" : "gone"},
          {"first_time", mapper.frames().time_of(past.first_frame)},
          {"last_time", mapper.frames().time_of(past.last_frame)},
          {"gone_time", mapper.frames().time_of(past.gone_frame)},
          {"appeared", false},
          {"moved_from", nullptr},
          {"moved_to", is_moved ? Json(number(past.moved_to)) : Json(nullptr)},
          {"votes", to_json(VoteHistory(), mapper.map().labels)},
          {"best_views", Json::array()},
          {"history", {fmt::format("after frame {}: gone, half of it and more was looked through", past.gone_frame)}}};
}

Json to_json(const MovingTrack& track, const LabelSet& labels) {
  Json frames = Json::array();
  for (const TrackedBox& box : track.boxes) {
    frames.push_back(
        {{"frame", box.frame}, {"time_s", box.time_s}, {"box", {{"min_m", to_json(box.min_m)}, {"max_m", to_json(box.max_m)}}}});
  }
  const bool is_named = track.class_id != ClassId::kUnknown;
  return {{"id", track.id},
          {"class", is_named ? Json(labels.name_of(track.class_id)) : Json(nullptr)},
          {"frames", std::move(frames)}};
}

Json to_json(const Object& object, const ObjectShape& shape, const Mapper& mapper) {
  const ClassId class_id = mapper.map().objects.class_of(object.slot);
  Json probabilities = Json::object();
  for (const ClassProbability& p : mapper.map().objects.probabilities(object.slot)) {
    probabilities[std::string(mapper.map().labels.name_of(p.class_id))] = p.probability;
  }
  Json json = {{"id", number(object.id)},
               {"class_id", number(class_id)},
               {"class", mapper.map().labels.name_of(class_id)},
               {"probabilities", std::move(probabilities)},
               {"box", {{"min_m", to_json(shape.min_m)}, {"max_m", to_json(shape.max_m)}}},
               {"oriented_box", to_json(shape.oriented_box)},
               {"centroid_m", to_json(shape.centroid_m)},
               {"surface_area_m2", shape.area_m2},
               {"vertices", shape.vertices},
               {"first_frame", object.first_frame},
               {"last_frame", object.last_frame},
               {"observations", object.observations},
               {"votes", to_json(object.votes, mapper.map().labels)},
               {"best_views", to_json(object.best_views, mapper.map().labels)},
               {"history", history_json(object, class_id, mapper.map().labels)}};
  add_presence(object, mapper, json);
  return json;
}

void add_map(const VoxelMap& map, Json& report) {
  const std::size_t observed = map.observed_voxels();
  const auto bytes = static_cast<double>(map.memory_bytes());
  report["block_count"] = map.block_count();
  report["observed_voxels"] = observed;
  report["map_memory_mb"] = bytes / 1e6;
  report["memory_bytes_per_observed_voxel"] = observed > 0 ? Json(bytes / static_cast<double>(observed)) : Json(nullptr);
  report["map_hash"] = fmt::format("{:016x}", map.hash());
}

std::size_t labelled_vertices(const Mesh& mesh, const PanopticMap& map) {
  std::map<PanopticId, bool> was_predicted;
  std::size_t count = 0;
  for (const MeshVertex& vertex : mesh.vertices) {
    if (vertex.class_id == ClassId::kUnknown) continue;
    const auto [at, added] = was_predicted.try_emplace(vertex.panoptic_id, true);
    if (const Object* object = added ? map.objects.find(vertex.panoptic_id) : nullptr) at->second = object->observations > 0;
    count += at->second ? 1 : 0;
  }
  return count;
}

}  // namespace

std::vector<RunRecording> recordings_of(const Dataset& dataset) {
  std::vector<RunRecording> recordings;
  const RecordingList* list = as_recording_list(dataset);
  if (list == nullptr) return recordings;
  for (const RecordingList::Part& part : list->parts()) {
    const ListedRecording& r = part.listed;
    recordings.push_back(
        {r.recording, r.calibration, r.predictions, r.world_from_recording, part.first_number, part.dataset->size()});
  }
  return recordings;
}

Json objects_json(const Mapper& mapper, const Mesh& mesh) {
  Json objects = Json::array();
  for (const ObjectShape& shape : object_shapes(mesh)) {
    const Object* object = mapper.map().objects.find(shape.id);
    if (object != nullptr) objects.push_back(to_json(*object, shape, mapper));
  }
  for (const PastObject& past : mapper.map().history.past) objects.push_back(to_json(past, mapper));
  std::sort(objects.begin(), objects.end(), [](const Json& a, const Json& b) { return a["id"] < b["id"]; });
  Json merged_into = Json::object();
  for (const MergedObject& m : mapper.map().objects.merged()) merged_into[std::to_string(number(m.id))] = number(m.into);
  return {{"objects", std::move(objects)}, {"merged_into", std::move(merged_into)}};
}

Json moving_json(const Mapper& mapper) {
  const MovingTracks& moving = mapper.parts().moving_tracks();
  Json tracks = Json::array();
  for (const MovingTrack& track : moving.tracks()) tracks.push_back(to_json(track, mapper.map().labels));
  return {{"tracks", std::move(tracks)}, {"forgotten_boxes", moving.state().forgotten}};
}

Json report_json(const Mapper& mapper, const Options& options, const RunSummary& run, const Mesh& mesh) {
  Options copy = options;
  Json report = {{"program", fmt::format("panoptic {}", version())},
                 {"dataset", run.dataset},
                 {"recording", run.recording},
                 {"calibration", run.calibration.empty() ? Json(nullptr) : Json(run.calibration)},
                 {"assumed", run.notes.assumed},
                 {"left_out", run.notes.left_out},
                 {"predictor", run.predictor},
                 {"complete", run.complete}};
  for (const RunRecording& recording : run.recordings) report["recordings"].push_back(to_json(recording));
  if (run.pair_tolerance_s) report["pair_tolerance_s"] = *run.pair_tolerance_s;
  if (!run.complete) report["stopped_by"] = run.stopped_by;
  report["frames"] = to_json(mapper.frames());
  report["frames"]["without_prediction"] = run.without_prediction;
  report["wall_s"] = run.wall_s;
  report["frames_per_s"] = run.wall_s > 0 ? static_cast<double>(mapper.frames().used()) / run.wall_s : 0;
  if (run.online) report["online"] = to_json(*run.online);
  if (run.tracking) report["tracking"] = to_json(*run.tracking);
  for (const Correction& correction : run.corrections) report["corrections"].push_back(to_json(correction));
  report["stages"] = to_json(mapper.profile());
  report["peak_rss_mb"] = peak_rss_mb();
  add_map(mapper.map().voxels, report);
  report["mesh"] = {{"vertices", mesh.vertices.size()}, {"triangles", mesh.triangles.size()}};
  report["up"] = to_json(mapper.up());
  std::size_t arrived = 0;
  for (const auto& [id, arrival] : mapper.map().history.arrivals) arrived += arrival.moved_from == PanopticId::kUnknown ? 1 : 0;
  report["changes"] = {{"gone", mapper.map().history.past.size()},
                       {"new", arrived},
                       {"moved", mapper.map().history.arrivals.size() - arrived},
                       {"tracks", mapper.parts().moving_tracks().tracks().size()}};
  report["objects_refused"] = mapper.map().objects.refused();
  report["label_set"] = mapper.map().labels.name();
  report["labels"] = classes_json(mapper.map().labels);
  report["options"] = to_json(fields(copy));
  return report;
}

WrittenMap write_outputs(const std::filesystem::path& folder, Mapper& mapper, const Options& options, const RunSummary& run) {
  const Mesh mesh = mapper.parts().last_mesh();
  const auto step = [](const auto& write) {
    write();
    give_back_free_memory();  // so that what one file took is not added to what the next one takes
  };
  step([&] { write_ply(folder / "mesh.ply", mesh); });
  step([&] { write_json_file(folder / "objects.json", objects_json(mapper, mesh)); });
  write_json_file(folder / "moving.json", moving_json(mapper));
  write_file(folder / "options.toml", to_toml(options));
  write_file(folder / "trajectory.txt", trajectory_text(mapper.frames().trajectory()));
  write_tracking(folder, run.tracking);
  step([&] { write_glb(folder / "scene.glb", mesh, mapper.map().labels, mapper.up()); });
  step([&] {
    run.pictures ? write_views(folder / "views", mesh, mapper.up(), mapper.map().labels) : remove_views(folder / "views");
  });
  write_json_file(folder / "report.json", report_json(mapper, options, run, mesh));
  return {mesh.triangles.size(), labelled_vertices(mesh, mapper.map())};
}

}  // namespace panoptic
