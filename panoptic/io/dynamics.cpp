// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/dynamics.h"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <string_view>
#include <utility>

#include "panoptic/base/json.h"
#include "panoptic/base/json_value.h"

namespace panoptic {
namespace {

constexpr const char* kFormat = "panoptic dynamics";
constexpr int kVersion = 1;
constexpr double kFarthest_m = 1e6;
constexpr std::int64_t kMostFrames = 1'000'000'000;
constexpr std::uintmax_t kMaxBytes = std::uintmax_t{1} << 30;
constexpr std::array<std::pair<EventKind, const char*>, 4> kKinds = {
    {{EventKind::kRemoved, "removed"}, {EventKind::kMoved, "moved"}, {EventKind::kAdded, "added"}, {EventKind::kDoor, "door"}}};

Json json_of(const Vec3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json json_of(const Eigen::AlignedBox3d& box) { return {{"min_m", json_of(box.min())}, {"max_m", json_of(box.max())}}; }

template <typename Value>
Json maybe(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json maybe(const std::optional<Eigen::AlignedBox3d>& box) { return box ? json_of(*box) : Json(nullptr); }

Json json_of(const TrueStay& stay) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    Json numbers = Json::array();
    for (int column = 0; column < 4; ++column) numbers.push_back(stay.world_from_object.matrix()(row, column));
    rows.push_back(std::move(numbers));
  }
  return {{"first_frame", stay.first_frame},
          {"last_frame", stay.last_frame},
          {"box", json_of(stay.box)},
          {"world_from_object", std::move(rows)},
          {"ended_by", stay.ended_by ? Json(name_of(*stay.ended_by)) : Json(nullptr)}};
}

Json json_of(const TrueThing& thing) {
  Json stays = Json::array();
  for (const TrueStay& stay : thing.stays) stays.push_back(json_of(stay));
  return {{"instance", thing.instance},
          {"class", thing.class_name},
          {"class_id", number(thing.class_id)},
          {"name", thing.name},
          {"intervals", std::move(stays)}};
}

Json json_of(const PlaceViews& views) {
  return {{"frames_before", views.before}, {"frames_after", views.after}, {"visible_again_frame", maybe(views.first_after)}};
}

Json json_of(const TrueChange& change, double rate_hz) {
  return {{"frame", change.frame},
          {"time_s", static_cast<double>(change.frame) / rate_hz},
          {"event", name_of(change.kind)},
          {"instance", change.instance},
          {"class", change.class_name},
          {"old_box", maybe(change.old_box)},
          {"new_box", maybe(change.new_box)},
          {"old_place", json_of(change.old_place)},
          {"new_place", json_of(change.new_place)}};
}

Json json_of(const TrueMover& mover, double rate_hz) {
  Json frames = Json::array();
  for (const TrueMover::Moment& m : mover.frames) {
    frames.push_back({{"frame", m.frame},
                      {"time_s", static_cast<double>(m.frame) / rate_hz},
                      {"activity", m.activity},
                      {"box", json_of(m.box)}});
  }
  return {{"instance", mover.instance},
          {"class", mover.class_name},
          {"class_id", number(mover.class_id)},
          {"frames", std::move(frames)}};
}

Eigen::AlignedBox3d box_in(const JsonValue& value) {
  Eigen::AlignedBox3d box(value.at("min_m").point(), value.at("max_m").point());
  if (box.isEmpty()) value.wrong("a box whose min_m is not above its max_m");
  return box;
}

std::optional<Eigen::AlignedBox3d> maybe_box_in(const JsonValue& value) {
  return value.is_null() ? std::nullopt : std::optional(box_in(value));
}

std::int64_t frame_in(const JsonValue& value) { return value.integer(0, kMostFrames); }

std::uint16_t small_in(const JsonValue& value) {
  return static_cast<std::uint16_t>(value.integer(0, std::numeric_limits<std::uint16_t>::max()));
}

EventKind kind_in(const JsonValue& value) {
  const std::string text = value.text();
  for (const auto& [kind, name] : kKinds) {
    if (text == name) return kind;
  }
  value.wrong("removed, moved, added or door");
}

Pose pose_in(const JsonValue& value) {
  const std::vector<JsonValue> rows = value.elements();
  if (rows.size() != 4) value.wrong("four rows");
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    const std::vector<JsonValue> numbers = rows[static_cast<std::size_t>(row)].elements();
    if (numbers.size() != 4) value.wrong("rows of four numbers");
    for (int column = 0; column < 4; ++column) {
      matrix(row, column) = numbers[static_cast<std::size_t>(column)].number(-kFarthest_m, kFarthest_m);
    }
  }
  Pose pose = Pose::Identity();
  pose.matrix() = matrix;
  return pose;
}

PlaceViews views_in(const JsonValue& value) {
  PlaceViews views{frame_in(value.at("frames_before")), frame_in(value.at("frames_after")), std::nullopt};
  if (const JsonValue first = value.at("visible_again_frame"); !first.is_null()) views.first_after = frame_in(first);
  return views;
}

TrueThing thing_in(const JsonValue& value) {
  TrueThing thing{small_in(value.at("instance")),
                  static_cast<ClassId>(small_in(value.at("class_id"))),
                  value.at("class").text(),
                  value.at("name").text(),
                  {}};
  for (const JsonValue& interval : value.at("intervals").elements()) {
    TrueStay& stay = thing.stays.emplace_back();
    stay.first_frame = frame_in(interval.at("first_frame"));
    stay.last_frame = frame_in(interval.at("last_frame"));
    stay.box = box_in(interval.at("box"));
    stay.world_from_object = pose_in(interval.at("world_from_object"));
    if (const JsonValue ended = interval.at("ended_by"); !ended.is_null()) stay.ended_by = kind_in(ended);
  }
  return thing;
}

TrueChange change_in(const JsonValue& value) {
  TrueChange change;
  change.frame = frame_in(value.at("frame"));
  change.kind = kind_in(value.at("event"));
  change.instance = small_in(value.at("instance"));
  change.class_name = value.at("class").text();
  change.old_box = maybe_box_in(value.at("old_box"));
  change.new_box = maybe_box_in(value.at("new_box"));
  change.old_place = views_in(value.at("old_place"));
  change.new_place = views_in(value.at("new_place"));
  return change;
}

TrueMover mover_in(const JsonValue& value) {
  TrueMover mover{
      small_in(value.at("instance")), static_cast<ClassId>(small_in(value.at("class_id"))), value.at("class").text(), {}};
  for (const JsonValue& moment : value.at("frames").elements()) {
    mover.frames.push_back({frame_in(moment.at("frame")), moment.at("activity").text(), box_in(moment.at("box"))});
  }
  return mover;
}

}  // namespace

const char* name_of(EventKind kind) {
  for (const auto& [known, name] : kKinds) {
    if (known == kind) return name;
  }
  return "";
}

std::string moving_mask_name(std::int64_t frame) { return fmt::format("{:06}.png", frame); }

void write_dynamics(const std::filesystem::path& path, const DynamicsTruth& truth) {
  Json json = {{"format", kFormat},      {"version", kVersion},      {"dynamics", truth.dynamics}, {"rate_hz", truth.rate_hz},
               {"frames", truth.frames}, {"objects", Json::array()}, {"changes", Json::array()},   {"movers", Json::array()}};
  for (const TrueThing& thing : truth.things) json["objects"].push_back(json_of(thing));
  for (const TrueChange& change : truth.changes) json["changes"].push_back(json_of(change, truth.rate_hz));
  for (const TrueMover& mover : truth.movers) json["movers"].push_back(json_of(mover, truth.rate_hz));
  write_json_file(path, json);
}

DynamicsTruth read_dynamics(const std::filesystem::path& path) {
  const Json json = read_json_file(path, kMaxBytes);
  const JsonValue root(json, path.string());
  if (root.at("format").text() != kFormat) root.at("format").wrong(fmt::format("\"{}\"", kFormat));
  if (root.at("version").integer(1, std::numeric_limits<int>::max()) != kVersion) {
    root.at("version").wrong(fmt::format("{}, the only one that this program reads", kVersion));
  }
  DynamicsTruth truth;
  truth.dynamics = root.at("dynamics").text();
  truth.rate_hz = root.at("rate_hz").number(1e-3, 1e6);
  truth.frames = frame_in(root.at("frames"));
  for (const JsonValue& thing : root.at("objects").elements()) truth.things.push_back(thing_in(thing));
  for (const JsonValue& change : root.at("changes").elements()) truth.changes.push_back(change_in(change));
  for (const JsonValue& mover : root.at("movers").elements()) truth.movers.push_back(mover_in(mover));
  return truth;
}

}  // namespace panoptic
