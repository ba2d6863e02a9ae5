// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

#include "panoptic/base/files.h"
#include "panoptic/base/json_value.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMostId = std::numeric_limits<std::uint32_t>::max();
constexpr double kFarthest_m = 1e6;

std::uint32_t id_of(const JsonValue& value) { return static_cast<std::uint32_t>(value.integer(0, kMostId)); }

std::uint64_t count_of(const JsonValue& value) { return static_cast<std::uint64_t>(value.integer(0, kMost)); }

Vec3d vector_of(const JsonValue& value) {
  const std::vector<JsonValue> c = value.elements();
  if (c.size() != 3) value.wrong("three numbers");
  return {c[0].number(-kFarthest_m, kFarthest_m), c[1].number(-kFarthest_m, kFarthest_m), c[2].number(-kFarthest_m, kFarthest_m)};
}

template <typename Value>
void sort_by_value(std::vector<std::pair<std::string, Value>>& pairs) {
  std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
}

PixelBox box_of(const JsonValue& value) {
  const std::vector<JsonValue> c = value.elements();
  if (c.size() != 4) value.wrong("four numbers");
  constexpr std::int64_t kWidest = 1 << 24;
  const auto px = [&](std::size_t i) { return static_cast<int>(c[i].integer(0, kWidest)); };
  const PixelBox box = {px(0), px(1), px(2), px(3)};
  if (box.u0 >= box.u1 || box.v0 >= box.v1) value.wrong("a box that is not empty");
  return box;
}

void read_votes(const JsonValue& votes, Evidence& evidence) {
  evidence.frames_per_stretch = static_cast<std::uint64_t>(votes.at("frames_per_bin").integer(1, kMost));
  for (const JsonValue& bin : votes.at("bins").elements()) {
    Evidence::Stretch stretch{bin.at("first_frame").integer(kLeast, kMost), {}};
    for (const auto& [name, count] : bin.at("classes").members()) stretch.votes.emplace_back(name, count_of(count));
    sort_by_value(stretch.votes);
    evidence.stretches.push_back(std::move(stretch));
  }
}

// An action may be logged as a text or as an object, whose members are put in a row.
std::string history_line(const Json& entry) {
  if (entry.is_string()) return entry.get<std::string>();
  std::string line;
  for (const auto& [key, value] : entry.items()) {
    line += fmt::format("{}{} {}", line.empty() ? "" : ", ", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
  return line;
}

Evidence read_object(const JsonValue& object) {
  Evidence e;
  e.id = id_of(object.at("id"));
  e.class_name = object.at("class").text();
  for (const auto& [name, p] : object.at("probabilities").members()) e.probabilities.emplace_back(name, p.number(0, 1.001));
  sort_by_value(e.probabilities);
  e.first_frame = object.at("first_frame").integer(kLeast, kMost);
  e.last_frame = object.at("last_frame").integer(kLeast, kMost);
  e.observations = count_of(object.at("observations"));
  if (const auto votes = object.find("votes")) read_votes(*votes, e);
  const auto views = object.find("best_views");
  for (const JsonValue& view : views ? views->elements() : std::vector<JsonValue>{}) {
    e.sights.push_back({view.at("frame").integer(kLeast, kMost), view.at("class").text(), view.at("score").number(0, 1.001),
                        count_of(view.at("visible_px")), box_of(view.at("box_px"))});
  }
  e.min_m = vector_of(object.at("box").at("min_m"));
  e.max_m = vector_of(object.at("box").at("max_m"));
  e.size_m = vector_of(object.at("oriented_box").at("size_m"));
  e.area_m2 = object.at("surface_area_m2").number(0, kFarthest_m * kFarthest_m);
  return e;
}

// Which object an id that was merged away went to: {"33": 31} beside the list of objects.
std::map<std::uint32_t, std::uint32_t> read_mergers(const JsonValue& file) {
  std::map<std::uint32_t, std::uint32_t> into;
  const auto merged = file.find("merged_into");
  if (!merged) return into;
  for (const auto& [name, survivor] : merged->members()) {
    const bool digits = !name.empty() && name.size() <= 10 && name.find_first_not_of("0123456789") == std::string::npos;
    if (!digits || std::stoll(name) > kMostId) merged->wrong("an object whose keys are ids");
    into[static_cast<std::uint32_t>(std::stoll(name))] = id_of(survivor);
  }
  return into;
}

// Survivors may have been merged themselves. No chain is longer than the list, unless it bites its tail.
std::uint32_t survivor_of(std::uint32_t id, const std::map<std::uint32_t, std::uint32_t>& into) {
  for (std::size_t step = 0; step < into.size(); ++step) {
    const auto next = into.find(id);
    if (next == into.end()) break;
    id = next->second;
  }
  return id;
}

[[noreturn]] void no_such_object(const std::filesystem::path& path, std::uint32_t id, const std::vector<std::uint32_t>& ids) {
  if (ids.empty()) throw Error(fmt::format("{}: the map has no objects, so none has the id {}", path.string(), id));
  const auto [least, most] = std::minmax_element(ids.begin(), ids.end());
  const auto nearest = *std::min_element(ids.begin(), ids.end(),
                                         [&](std::int64_t a, std::int64_t b) { return std::abs(a - id) < std::abs(b - id); });
  throw Error(fmt::format("{}: no object has the id {}; there are {} from {} to {}, the nearest is {}", path.string(), id,
                          ids.size(), *least, *most, nearest));
}

std::string counts_text(const std::vector<std::pair<std::string, std::uint64_t>>& counts) {
  std::string text;
  for (const auto& [name, count] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
  return text;
}

std::string votes_text(const Evidence& e) {
  if (e.stretches.empty()) return "  votes          not written down by this run\n";
  std::string text = fmt::format("  votes          in stretches of {} frames, from frame\n", e.frames_per_stretch);
  for (const Evidence::Stretch& s : e.stretches) text += fmt::format("    {:>9}    {}\n", s.first_frame, counts_text(s.votes));
  return text;
}

std::string sights_text(const Evidence& e) {
  if (e.sights.empty()) return "  best frames    not written down by this run\n";
  std::string text = "  best frames    as, score, visible pixels, box in the colour image\n";
  for (const Evidence::Sight& s : e.sights) {
    text += fmt::format("    {:>9}    {} {:.2f}, {} px, ({}, {}) to ({}, {})\n", s.frame, s.class_name, s.score, s.visible_px,
                        s.box.u0, s.box.v0, s.box.u1, s.box.v1);
  }
  return text;
}

}  // namespace

Evidence read_evidence(const std::filesystem::path& run, std::uint32_t id) {
  const std::filesystem::path path = run / "objects.json";
  if (!is_file(path)) {
    throw Error(fmt::format("{}: no objects.json in it; name the folder that panoptic run wrote", run.string()));
  }
  const Json json = read_json_file(path);
  const JsonValue file(json, path.string());
  const std::uint32_t survivor = survivor_of(id, read_mergers(file));
  std::vector<std::uint32_t> ids;
  const std::vector<JsonValue> objects = file.at("objects").elements();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    ids.push_back(id_of(objects[i].at("id")));
    if (ids.back() != survivor) continue;
    Evidence evidence = read_object(objects[i]);
    evidence.asked_id = id;
    const Json& entry = json["objects"][i];
    if (entry.contains("history") && entry["history"].is_array()) {
      for (const Json& action : entry["history"]) evidence.history.push_back(history_line(action));
    }
    return evidence;
  }
  no_such_object(path, id, ids);
}

std::string to_text(const Evidence& e) {
  std::string text;
  if (e.asked_id != e.id) text += fmt::format("object {} became part of {}\n", e.asked_id, e.id);
  text += fmt::format("{} {}\n  probabilities  ", e.class_name, e.id);
  for (std::size_t i = 0; i < e.probabilities.size(); ++i) {
    text += fmt::format("{}{} {:.3f}", i == 0 ? "" : ", ", e.probabilities[i].first, e.probabilities[i].second);
  }
  if (e.probabilities.empty()) text += "none: it was never detected under this id";
  text += fmt::format("\n  seen           frames {} to {}, {} observations\n", e.first_frame, e.last_frame, e.observations);
  text += fmt::format("  size           {:.2f} x {:.2f} x {:.2f} m, {:.2f} m2 of surface\n", e.size_m.x(), e.size_m.y(),
                      e.size_m.z(), e.area_m2);
  text += fmt::format("  box            ({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f}) m\n", e.min_m.x(), e.min_m.y(),
                      e.min_m.z(), e.max_m.x(), e.max_m.y(), e.max_m.z());
  text += votes_text(e) + sights_text(e);
  if (!e.history.empty()) text += "  history\n";
  for (const std::string& line : e.history) text += fmt::format("    {}\n", line);
  return text;
}

}  // namespace panoptic
