// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/run_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "panoptic/base/files.h"
#include "panoptic/base/json_value.h"
#include "panoptic/data/label_json.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_text.h"
#include "panoptic/outputs.h"

namespace panoptic {
namespace {

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMostClass = std::numeric_limits<std::uint16_t>::max();
constexpr std::int64_t kMostId = std::numeric_limits<std::uint32_t>::max();
constexpr double kMostProbable = 1.001;  // sums of floats
constexpr double kFarthest_m = 1e6;
constexpr double kLongest = 1e12;  // times and rates

std::filesystem::path file_of_run(const std::filesystem::path& folder, const char* name) {
  if (is_file(folder / name)) return folder / name;
  throw Error(fmt::format("{}: no {} in it; name the folder that panoptic run wrote", folder.string(), name));
}

PanopticId id_in(const JsonValue& value) { return static_cast<PanopticId>(value.integer(0, kMostId)); }

ClassId class_in(const JsonValue& value) { return static_cast<ClassId>(value.integer(0, kMostClass)); }

std::uint64_t count_in(const JsonValue& value) { return static_cast<std::uint64_t>(value.integer(0, kMost)); }

std::int64_t frame_in(const JsonValue& value) { return value.integer(kLeast, kMost); }

double probability_in(const JsonValue& value) { return value.number(0, kMostProbable); }

// Empty where there is none.
std::string text_in(const JsonValue& object, std::string_view key) {
  const auto value = object.find(key);
  return value && !value->is_null() ? value->text() : "";
}

std::vector<JsonValue> elements_in(const JsonValue& object, std::string_view key) {
  const auto value = object.find(key);
  return value ? value->elements() : std::vector<JsonValue>();
}

PixelBox box_in(const JsonValue& value) {
  const std::vector<JsonValue> c = value.elements();
  if (c.size() != 4) value.wrong("four numbers");
  constexpr std::int64_t kWidest = 1 << 24;
  const auto px = [&](std::size_t i) { return static_cast<int>(c[i].integer(0, kWidest)); };
  const PixelBox box = {px(0), px(1), px(2), px(3)};
  if (box.u0 >= box.u1 || box.v0 >= box.v1) value.wrong("a box that is not empty");
  return box;
}

template <typename Value>
void sort_by_value(std::vector<std::pair<std::string, Value>>& pairs) {
  std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
}

void read_votes(const JsonValue& votes, RunObject& object) {
  object.frames_per_bin = static_cast<std::uint64_t>(votes.at("frames_per_bin").integer(1, kMost));
  for (const JsonValue& bin : votes.at("bins").elements()) {
    RunObject::Votes& of_bin = object.votes.emplace_back();
    of_bin.first_frame = frame_in(bin.at("first_frame"));
    for (const auto& [name, count] : bin.at("classes").members()) of_bin.of_class.emplace_back(name, count_in(count));
    sort_by_value(of_bin.of_class);
  }
}

RunObject object_in(const JsonValue& entry) {
  RunObject object;
  object.id = id_in(entry.at("id"));
  object.class_id = class_in(entry.at("class_id"));
  object.class_name = entry.at("class").text();
  for (const auto& [name, p] : entry.at("probabilities").members()) object.probabilities.emplace_back(name, probability_in(p));
  sort_by_value(object.probabilities);
  object.first_frame = frame_in(entry.at("first_frame"));
  object.last_frame = frame_in(entry.at("last_frame"));
  object.observations = count_in(entry.at("observations"));
  object.vertices = count_in(entry.at("vertices"));
  object.min_m = entry.at("box").at("min_m").point();
  object.max_m = entry.at("box").at("max_m").point();
  object.size_m = entry.at("oriented_box").at("size_m").point();
  object.area_m2 = entry.at("surface_area_m2").number(0, kFarthest_m * kFarthest_m);
  if (const auto votes = entry.find("votes")) read_votes(*votes, object);
  for (const JsonValue& view : elements_in(entry, "best_views")) {
    object.best_views.push_back({frame_in(view.at("frame")), view.at("class").text(), probability_in(view.at("score")),
                                 count_in(view.at("visible_px")), box_in(view.at("box_px"))});
  }
  for (const JsonValue& action : elements_in(entry, "history")) object.history.push_back(action.text());
  return object;
}

// {"33": 31}
std::map<PanopticId, PanopticId> mergers_in(const JsonValue& file) {
  std::map<PanopticId, PanopticId> into;
  const auto merged = file.find("merged_into");
  if (!merged) return into;
  for (const auto& [name, survivor] : merged->members()) {
    std::uint32_t id = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
    if (error != std::errc() || end != name.data() + name.size()) merged->wrong("an object whose keys are ids");
    into[PanopticId{id}] = id_in(survivor);
  }
  return into;
}

}  // namespace

RunReport read_run_report(const std::filesystem::path& folder) {
  const std::filesystem::path path = file_of_run(folder, "report.json");
  const Json json = read_json_file(path);
  const JsonValue file(json, path.string());
  RunReport report;
  report.dataset = file.at("dataset").text();
  report.recording = text_in(file, "recording");
  report.calibration = text_in(file, "calibration");
  if (const auto tolerance_s = file.find("pair_tolerance_s")) report.pair_tolerance_s = tolerance_s->number(0, kLongest);
  report.predictor = text_in(file, "predictor");
  if (const auto complete = file.find("complete")) report.complete = complete->boolean();
  report.stopped_by = text_in(file, "stopped_by");
  report.frames_used = count_in(file.at("frames").at("used"));
  report.frames_skipped = count_in(file.at("frames").at("skipped"));
  if (const auto without = file.at("frames").find("without_prediction")) report.without_prediction = count_in(*without);
  report.wall_s = file.at("wall_s").number(0, kLongest);
  report.peak_rss_mb = file.at("peak_rss_mb").number(0, kLongest);
  for (const auto& [name, stage] : file.at("stages").members()) {
    const auto ms = [&, &entry = stage](const char* key) { return entry.at(key).number(0, kLongest); };
    report.stages[name] = {count_in(stage.at("count")), ms("mean_ms"), ms("p50_ms"), ms("p95_ms")};
  }
  report.tracked = file.find("tracking").has_value();
  report.up = file.at("up").point();
  const JsonValue labels = file.at("labels");
  report.labels = label_set_of(text_in(file, "label_set"), classes_in(labels), labels);
  report.voxel_size_m = file.at("options").at("map").at("voxel_size_m").number(1e-4, 100);
  return report;
}

RunObjects read_run_objects(const std::filesystem::path& folder) {
  const std::filesystem::path path = file_of_run(folder, "objects.json");
  const Json json = read_json_file(path);
  const JsonValue file(json, path.string());
  RunObjects objects;
  for (const JsonValue& entry : file.at("objects").elements()) objects.objects.push_back(object_in(entry));
  objects.merged_into = mergers_in(file);
  return objects;
}

Mesh read_run_mesh(const std::filesystem::path& folder) { return read_ply(file_of_run(folder, "mesh.ply")); }

std::vector<Vec3d> read_run_path(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "trajectory.txt";
  std::vector<Vec3d> path;
  if (!is_there(file)) return path;
  for_each_line(file, [&](std::size_t line, std::span<const std::string_view> words) {
    const std::vector<double> v = to_numbers(words, file, line);
    if (v.size() != 8 || !(Eigen::Array3d(v[1], v[2], v[3]).abs() <= kFarthest_m).all()) {
      throw Error(fmt::format("{}:{}: expected `time x y z qx qy qz qw`", file.string(), line));
    }
    path.emplace_back(v[1], v[2], v[3]);
  });
  return path;
}

}  // namespace panoptic
