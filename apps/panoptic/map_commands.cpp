// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// info, mesh, query, regularize and rebuild: what can be done with a map file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/numbers.h"
#include "apps/panoptic/progress.h"
#include "panoptic/bag.h"
#include "panoptic/base/json.h"
#include "panoptic/map_file.h"
#include "panoptic/mapfile/log_rows.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/rebuild_file.h"
#include "panoptic/mapping/regularize_file.h"
#include "panoptic/outputs.h"
#include "panoptic/parallel.h"
#include "panoptic/profile.h"
#include "panoptic/query.h"
#include "panoptic/sim/open_again.h"
#include "panoptic/simulation.h"
#include "panoptic/surface.h"

namespace panoptic {
namespace {

std::string note(const SavedMap& saved, const char* name) {
  const auto found = saved.notes.texts.find(name);
  return found == saved.notes.texts.end() ? "" : found->second;
}

Json to_json(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }

Json to_json(const FoundObject& o, const LabelSet& labels) {
  return {{"id", number(o.id)},
          {"class", labels.name_of(o.class_id)},
          {"probability", o.probability},
          {"center_m", to_json(o.box.center_m)},
          {"box", {{"min_m", to_json(o.box.min_m)}, {"max_m", to_json(o.box.max_m)}}},
          {"voxels", o.voxels},
          {"observations", o.observations},
          {"first_frame", o.first_frame},
          {"last_frame", o.last_frame}};
}

std::string line_of(const FoundObject& o, const LabelSet& labels) {
  const Vec3d c = o.box.center_m;
  const Vec3d size = o.box.max_m - o.box.min_m;
  return fmt::format("{:>6}  {:<16} at {:7.2f} {:7.2f} {:7.2f}  size {:5.2f} {:5.2f} {:5.2f} m  seen {} times", number(o.id),
                     labels.name_of(o.class_id), c.x(), c.y(), c.z(), size.x(), size.y(), size.z(), o.observations);
}

struct Answer {
  Json json;
  std::string text;
};

Answer list_answer(const std::vector<FoundObject>& objects, const LabelSet& labels) {
  Answer answer{Json::array(), ""};
  for (const FoundObject& o : objects) {
    answer.json.push_back(to_json(o, labels));
    answer.text += line_of(o, labels) + "\n";
  }
  if (objects.empty()) answer.text = "none\n";
  return answer;
}

Answer nearest_answer(const std::vector<NearObject>& near, const LabelSet& labels) {
  Answer answer{Json::array(), ""};
  for (const NearObject& n : near) {
    answer.json.push_back(to_json(n.object, labels));
    answer.json.back()["distance_m"] = n.distance_m;
    answer.text += fmt::format("{:8.3f} m  {}\n", n.distance_m, line_of(n.object, labels));
  }
  if (near.empty()) answer.text = "none\n";
  return answer;
}

Answer point_answer(const std::optional<PointAnswer>& at, const LabelSet& labels) {
  if (!at) return {nullptr, "nothing was observed there\n"};
  return {{{"id", number(at->id)},
           {"class", labels.name_of(at->class_id)},
           {"distance_m", at->distance_m},
           {"weight", at->weight},
           {"label_share", at->label_share}},
          fmt::format("{} (id {}), {:.3f} m from the surface, weight {:.2f}, {:.0f} % sure of the label\n",
                      labels.name_of(at->class_id), number(at->id), at->distance_m, at->weight, 100 * at->label_share)};
}

Json to_json(const ObjectSpan& s, const LabelSet& labels) {
  const auto id = [](PanopticId of) { return of == PanopticId::kUnknown ? Json(nullptr) : Json(number(of)); };
  const char* past = s.moved_to == PanopticId::kUnknown ? "gone" : "moved";
  return {{"id", number(s.id)},
          {"class", labels.name_of(s.class_id)},
          {"state", s.gone_s ? past : "present"},
          {"center_m", to_json(s.box.center_m)},
          {"box", {{"min_m", to_json(s.box.min_m)}, {"max_m", to_json(s.box.max_m)}}},
          {"first_time", s.first_s},
          {"gone_time", s.gone_s ? Json(*s.gone_s) : Json(nullptr)},
          {"appeared", s.appeared},
          {"moved_from", id(s.moved_from)},
          {"moved_to", id(s.moved_to)}};
}

// "seen from 1.2 s", "new at 3.0 s", "gone at 7.5 s", "moved at 7.5 s to 71".
std::string fate_of(const ObjectSpan& s) {
  if (s.moved_to != PanopticId::kUnknown) return fmt::format("moved at {:.1f} s to {}", *s.gone_s, number(s.moved_to));
  if (s.gone_s) return fmt::format("gone at {:.1f} s", *s.gone_s);
  if (s.moved_from != PanopticId::kUnknown) return fmt::format("moved here at {:.1f} s from {}", s.first_s, number(s.moved_from));
  return fmt::format("{} {:.1f} s", s.appeared ? "new at" : "seen from", s.first_s);
}

Answer span_answer(const std::vector<ObjectSpan>& spans, const LabelSet& labels) {
  Answer answer{Json::array(), spans.empty() ? "none\n" : ""};
  for (const ObjectSpan& s : spans) {
    const Vec3d c = s.box.center_m;
    answer.json.push_back(to_json(s, labels));
    answer.text += fmt::format("{:>6}  {:<16} at {:7.2f} {:7.2f} {:7.2f}  {}\n", number(s.id), labels.name_of(s.class_id), c.x(),
                               c.y(), c.z(), fate_of(s));
  }
  return answer;
}

Answer history_answer(const Arguments& a, const SavedMap& saved) {
  const std::vector<ObjectSpan> spans = object_spans(saved.map, load_frames(a.map));
  return span_answer(a.query_when ? present_at(spans, *a.query_when) : changed_since(spans, *a.query_since), saved.map.labels);
}

Answer answer_to(const Arguments& a, const MapQuery& query, const LabelSet& labels) {
  constexpr std::size_t kNearest = 5;
  if (!a.query_class.empty()) return list_answer(query.of_class(a.query_class), labels);
  if (!a.query_nearest.empty()) return nearest_answer(query.nearest(point_from(a.query_nearest, "--nearest"), kNearest), labels);
  if (!a.query_at.empty()) return point_answer(query.at(point_from(a.query_at, "--at")), labels);
  if (a.query_box.empty()) return list_answer(query.objects(), labels);
  const std::vector<double> n = numbers_from(a.query_box, 6, "--box");
  const Vec3d one(n[0], n[1], n[2]);
  const Vec3d other(n[3], n[4], n[5]);
  return list_answer(query.in_box(one.cwiseMin(other), one.cwiseMax(other)), labels);
}

// The box around all blocks, in metres.
ExtentBox bounds_of(const VoxelMap& map) {
  ExtentBox box{Vec3d::Zero(), Vec3d::Zero(), Vec3d::Zero()};
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockIndex i = map.index_of(slot);
    const Vec3d low = Vec3d(i.x, i.y, i.z) * double{map.block_size_m()};
    const Vec3d high = low + Vec3d::Constant(double{map.block_size_m()});
    box.min_m = slot == 0 ? low : Vec3d(box.min_m.cwiseMin(low));
    box.max_m = slot == 0 ? high : Vec3d(box.max_m.cwiseMax(high));
  }
  return box;
}

Json info_json(const std::string& path, const SavedMap& saved, const std::vector<FrameRecord>& frames) {
  const MapQuery query(saved.map);
  std::map<std::string, std::uint64_t> by_class;
  for (const FoundObject& o : query.objects()) ++by_class[std::string(saved.map.labels.name_of(o.class_id))];
  const auto used = std::count_if(frames.begin(), frames.end(), [](const FrameRecord& f) { return f.unused_because.empty(); });
  const ExtentBox box = bounds_of(saved.map.voxels);
  const std::uint64_t observed = saved.map.voxels.observed_voxels();
  const auto bytes = std::filesystem::file_size(path);
  const LogSize log = size_of_log(path);
  const auto of_map = static_cast<double>(bytes - std::min<std::uint64_t>(bytes, log.bytes));
  return {{"file", path},
          {"format", saved.format},
          {"program", note(saved, "program")},
          {"recording", note(saved, "recording")},
          {"complete", is_complete(saved)},
          {"frames", {{"read", frames.size()}, {"used", used}, {"skipped", static_cast<std::int64_t>(frames.size()) - used}}},
          {"voxel_size_m", saved.map.voxels.voxel_size_m()},
          {"bounds", {{"min_m", to_json(box.min_m)}, {"max_m", to_json(box.max_m)}}},
          {"blocks", saved.map.voxels.block_count()},
          {"observed_voxels", observed},
          {"file_bytes", bytes},
          {"log", {{"frames", log.frames}, {"copies", log.copies}, {"bytes", log.bytes}}},
          {"bytes_per_observed_voxel", observed > 0 ? of_map / static_cast<double>(observed) : 0.0},
          {"map_hash", fmt::format("{:016x}", saved.map.voxels.hash())},
          {"label_set", saved.map.labels.name()},
          {"objects", query.objects().size()},
          {"objects_by_class", by_class}};
}

std::string info_text(const Json& j) {
  const auto box = [&](const char* end, int axis) { return j["bounds"][end][static_cast<std::size_t>(axis)].get<double>(); };
  const auto length = [&](int axis) { return box("max_m", axis) - box("min_m", axis); };
  std::string text = fmt::format(
      "{}\nrecording {}\nstate     {}\nframes    {} used, {} skipped\nbounds    {:.1f} x {:.1f} x {:.1f} m from {:.2f} {:.2f} "
      "{:.2f}\n"
      "voxels    {} observed of {} m in {} blocks, {:.1f} MB, {:.1f} bytes each\nlog       {} frames, {} with copies of their "
      "images, {:.1f} MB of these\n"
      "hash      {}\nlabels    {}\nobjects   {}\n",
      j["file"].get<std::string>(), j["recording"].get<std::string>(),
      j["complete"].get<bool>() ? "complete" : "a checkpoint: run --map --resume goes on from here",
      j["frames"]["used"].get<int>(), j["frames"]["skipped"].get<int>(), length(0), length(1), length(2), box("min_m", 0),
      box("min_m", 1), box("min_m", 2), j["observed_voxels"].get<std::uint64_t>(), j["voxel_size_m"].get<float>(),
      j["blocks"].get<std::size_t>(), j["file_bytes"].get<double>() / 1e6, j["bytes_per_observed_voxel"].get<double>(),
      j["log"]["frames"].get<std::size_t>(), j["log"]["copies"].get<std::size_t>(), j["log"]["bytes"].get<double>() / 1e6,
      j["map_hash"].get<std::string>(), j["label_set"].get<std::string>(), j["objects"].get<std::size_t>());
  for (const auto& [name, count] : j["objects_by_class"].items()) text += fmt::format("  {:>5} x {}\n", count.get<int>(), name);
  return text;
}

int bag_info(const Arguments& a) {
  const BagListing bag = list_bag(a.map);
  Json json = {
      {"file", a.map}, {"container", bag.container}, {"begin_s", bag.begin_s}, {"end_s", bag.end_s}, {"left_out", bag.left_out}};
  json["topics"] = Json::array();
  for (const ListedTopic& t : bag.topics) {
    json["topics"].push_back({{"name", t.name}, {"type", t.type}, {"messages", t.messages}, {"role", t.role}, {"note", t.note}});
  }
  if (a.as_json) {
    fmt::print("{}\n", json.dump(2));
    return kDone;
  }
  fmt::print("{}\n{}, {:.1f} s from {:.3f}\n", a.map, bag.container, bag.end_s - bag.begin_s, bag.begin_s);
  for (const std::string& line : bag.left_out) fmt::print("left out  {}\n", line);
  for (const ListedTopic& t : bag.topics) {
    fmt::print("{:<6}{:>8} x {} ({}{}{})\n", t.role, t.messages, t.name, t.type, t.note.empty() ? "" : ", ", t.note);
  }
  return kDone;
}

}  // namespace

SavedMap load_map_and_tell(const std::string& path) {
  SavedMap saved = load_map(path);
  tell_note(note_of_format(saved, path));
  return saved;
}

Mesh mesh_of(const SavedMap& saved) { return surface_of(saved.map, options_of(saved).mesher); }

void tell_note(const std::string& note) {
  if (!note.empty()) fmt::print(stderr, "note: {}\n", note);
}

int map_info(const Arguments& a) {
  set_thread_count(a.threads);
  if (is_bag_recording(a.map)) return bag_info(a);
  const SavedMap saved = load_map_and_tell(a.map);
  const Json json = info_json(a.map, saved, load_frames(a.map));
  fmt::print("{}", a.as_json ? json.dump(2) + "\n" : info_text(json));
  return kDone;
}

int map_mesh(const Arguments& a) {
  const bool glb = a.output.ends_with(".glb");
  if (!glb && !a.output.ends_with(".ply")) throw UsageError("-o takes a name that ends in .ply or .glb");
  set_thread_count(a.threads);
  const SavedMap saved = load_map_and_tell(a.map);
  const Mesh mesh = mesh_of(saved);
  if (glb) {
    write_glb(a.output, mesh, saved.map.labels, up_of(saved));
  } else {
    write_ply(a.output, mesh);
  }
  fmt::print("{} vertices, {} triangles in {}\n", mesh.vertices.size(), mesh.triangles.size(), a.output);
  return kDone;
}

int map_query(const Arguments& a) {
  const std::size_t questions =
      static_cast<std::size_t>(!a.query_class.empty()) + static_cast<std::size_t>(!a.query_box.empty()) +
      static_cast<std::size_t>(!a.query_nearest.empty()) + static_cast<std::size_t>(!a.query_at.empty()) +
      static_cast<std::size_t>(a.query_when.has_value()) + static_cast<std::size_t>(a.query_since.has_value());
  if (questions > 1) {
    throw UsageError("one question at a time: --class, --box, --nearest, --at, --when or --changes-since");
  }
  for (const std::optional<double>& time_s : {a.query_when, a.query_since}) {
    if (time_s && !std::isfinite(*time_s)) throw UsageError("a time is a number of seconds");
  }
  set_thread_count(a.threads);
  const SavedMap saved = load_map_and_tell(a.map);
  const bool asks_history = a.query_when || a.query_since;
  const Answer answer = asks_history ? history_answer(a, saved) : answer_to(a, MapQuery(saved.map), saved.map.labels);
  fmt::print("{}", a.as_json ? answer.json.dump(2) + "\n" : answer.text);
  return kDone;
}

int map_regularize(const Arguments& a) {
  set_thread_count(a.threads);
  for (const std::string& setting : a.settings) {
    try {
      Options options;
      set_option(options, setting);
    } catch (const Error& e) {
      throw UsageError(e.what());
    }
  }
  const RegularizedFile file = regularize_map_file(a.map, a.settings);
  tell_note(file.note);
  fmt::print("{} of {} blocks have other labels now, {} objects\n", file.changed, file.blocks, file.objects);
  return kDone;
}

int map_rebuild(const Arguments& a) {
  set_thread_count(a.threads);
  const auto dataset = [&]() -> std::unique_ptr<Dataset> {
    if (a.dataset.empty() && has_copies(a.map)) return nullptr;
    const MappedRecording mapped = mapped_recording(a.map);
    const std::string& recording = a.dataset.empty() ? mapped.recording : a.dataset;
    try {
      return open_again(recording, mapped.calibration, mapped.pair_tolerance_s, mapped.is_tracked);
    } catch (const Error& e) {
      throw Error(
          fmt::format("the recording of the map cannot be opened: {}; if it has moved, name it: --recording PATH", e.what()));
    }
  }();
  std::optional<Progress> progress;
  const RebuiltFile rebuilt = rebuild_map_file(a.map, a.poses, dataset.get(), a.output, [&](std::size_t done, std::size_t all) {
    if (!progress) progress.emplace("frames", all);
    progress->advance(done + 1);
  });
  progress.reset();
  const Correction& c = rebuilt.correction;
  if (c.frames == 0) tell_note("no pose differs from the map's by more than map.pose_tolerance_m: the new map is the old one");
  if (rebuilt.left_over > 0) tell_note(fmt::format("{} poses of {} are of no frame of the map", rebuilt.left_over, a.poses));
  fmt::print("poses     for {} of {} frames, {} of them other than before\n", rebuilt.given, rebuilt.used, c.frames);
  fmt::print("rebuilt   {} of {} blocks in {:.1f} s, {:.1f} s of it waiting for frames; {} objects\n", c.blocks_refused, c.blocks,
             c.ms / 1000, c.wait_ms / 1000, rebuilt.objects);
  fmt::print("look at   panoptic view {0}, panoptic mesh {0} -o mesh.ply\n", a.output);
  return kDone;
}

}  // namespace panoptic
