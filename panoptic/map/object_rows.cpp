// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/object_rows.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "panoptic/base/error.h"
#include "panoptic/base/json.h"

namespace panoptic {
namespace {

constexpr const char* kPut =
    "INSERT OR REPLACE INTO objects(id, merged_into, class_id, probability, first_frame, last_frame, observations, score_sum, "
    "evidence, "
    "ruled_out, votes, best_views, parts, voxels, x_m, y_m, z_m, min_x_m, min_y_m, min_z_m, max_x_m, max_y_m, max_z_m) "
    "VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)";
constexpr const char* kSelect =
    "SELECT id, merged_into, first_frame, last_frame, observations, score_sum, evidence, ruled_out, votes, best_views, parts "
    "FROM objects ORDER BY id";
constexpr std::size_t kMostText = 1 << 20;
constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

double probability_of(const Object& object, ClassId class_id) {
  const auto evidence = object.evidence.find(class_id);
  return evidence == object.evidence.end() || object.score_sum <= 0 ? 0.0 : evidence->second / object.score_sum;
}

template <typename Value>
Json by_class(const std::map<ClassId, Value>& values) {
  Json json = Json::object();
  for (const auto& [class_id, value] : values) json[std::to_string(number(class_id))] = value;
  return json;
}

Json votes_json(const VoteHistory& votes) {
  Json bins = Json::array();
  for (const VoteHistory::Bin& bin : votes.bins()) bins.push_back(Json::array({bin.number, by_class(bin.votes)}));
  return {{"log2", votes.log2_frames_per_bin()}, {"bins", std::move(bins)}};
}

Json views_json(const BestViews& best) {
  Json views = Json::array();
  for (const ObjectView& v : best.views()) {
    views.push_back({v.frame, number(v.class_id), v.score, v.visible_px, v.box.u0, v.box.v0, v.box.u1, v.box.v1});
  }
  return views;
}

Json parts_json(const std::vector<ObjectPart>& parts) {
  Json list = Json::array();
  for (const ObjectPart& part : parts) list.push_back({number(part.id), part.frame});
  return list;
}

Json classes_json(const std::set<ClassId>& classes) {
  Json list = Json::array();
  for (const ClassId id : classes) list.push_back(number(id));
  return list;
}

// Reads the JSON of one row. What is not as it was written throws std::exception, whatever it is: the caller says which row.
struct RowError : std::exception {};

void require(bool condition) {
  if (!condition) throw RowError();
}

std::int64_t whole(const Json& json, std::int64_t min, std::int64_t max) {
  require(json.is_number_integer());
  require(!json.is_number_unsigned() || json.get<std::uint64_t>() <= static_cast<std::uint64_t>(kMost));
  const auto value = json.get<std::int64_t>();
  require(value >= min && value <= max);
  return value;
}

double finite(const Json& json) {
  require(json.is_number());
  const auto value = json.get<double>();
  require(std::isfinite(value) && value >= 0);
  return value;
}

float finite_float(const Json& json) {
  const double value = finite(json);
  require(value <= static_cast<double>(std::numeric_limits<float>::max()));
  return static_cast<float>(value);
}

ClassId class_from(const std::string& text) {
  std::uint16_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  require(error == std::errc() && end == text.data() + text.size());
  return ClassId{id};
}

Json json_from(std::string_view text) {
  require(text.size() <= kMostText);
  std::optional<Json> json = json_in(text);
  require(json.has_value());
  return std::move(*json);
}

VoteHistory votes_from(const Json& json) {
  require(json.is_object() && json.contains("log2") && json.contains("bins") && json["bins"].is_array());
  require(json["bins"].size() <= VoteHistory::kMostBins);
  std::vector<VoteHistory::Bin> bins;
  for (const Json& entry : json["bins"]) {
    require(entry.is_array() && entry.size() == 2 && entry[1].is_object() && !entry[1].empty());
    VoteHistory::Bin bin{whole(entry[0], std::numeric_limits<std::int64_t>::min(), kMost), {}};
    require(bins.empty() || bins.back().number < bin.number);
    for (const auto& [key, count] : entry[1].items()) {
      bin.votes[class_from(key)] = static_cast<std::uint64_t>(whole(count, 1, kMost));
    }
    bins.push_back(std::move(bin));
  }
  return {std::move(bins), static_cast<int>(whole(json["log2"], 0, VoteHistory::kMostLog2))};
}

BestViews views_from(const Json& json) {
  constexpr std::int64_t kMostPixels = 1 << 30;
  require(json.is_array() && json.size() <= BestViews::kMost);
  BestViews best;
  for (const Json& v : json) {
    require(v.is_array() && v.size() == 8);
    const auto pixel = [&](std::size_t i) { return static_cast<int>(whole(v[i], -kMostPixels, kMostPixels)); };
    best.add({.frame = whole(v[0], std::numeric_limits<std::int64_t>::min(), kMost),
              .class_id = static_cast<ClassId>(whole(v[1], 0, 65535)),
              .score = finite_float(v[2]),
              .visible_px = static_cast<std::uint32_t>(whole(v[3], 0, std::numeric_limits<std::uint32_t>::max())),
              .box = {pixel(4), pixel(5), pixel(6), pixel(7)}});
  }
  return best;
}

Object object_from(const Statement& row) {
  Object object;
  object.id = static_cast<LabelSlot>(row.integer(0));
  object.first_frame = row.integer(2);
  object.last_frame = row.integer(3);
  object.observations = static_cast<std::uint64_t>(row.integer(4, 0, kMost));
  object.score_sum = row.real(5);
  require(std::isfinite(object.score_sum) && object.score_sum >= 0);
  const Json evidence = json_from(row.text(6));
  require(evidence.is_object());
  for (const auto& [key, value] : evidence.items()) object.evidence[class_from(key)] = finite(value);
  const Json ruled_out = json_from(row.text(7));
  require(ruled_out.is_array());
  for (const Json& id : ruled_out) object.ruled_out.insert(static_cast<ClassId>(whole(id, 0, 65535)));
  object.votes = votes_from(json_from(row.text(8)));
  object.best_views = views_from(json_from(row.text(9)));
  const Json parts = json_from(row.text(10));
  require(parts.is_array());
  for (const Json& part : parts) {
    require(part.is_array() && part.size() == 2);
    object.parts.push_back(
        {static_cast<LabelSlot>(whole(part[0], 1, 65534)), whole(part[1], std::numeric_limits<std::int64_t>::min(), kMost)});
  }
  return object;
}

}  // namespace

std::map<LabelSlot, ObjectRow> object_rows(const ObjectRegistry& objects, const LabelExtents& extents) {
  std::map<LabelSlot, ObjectRow> rows;
  const RegistryState state = objects.state();
  for (std::size_t i = 0; i < state.objects.size(); ++i) {
    const Object& object = state.objects[i];
    const auto id = static_cast<LabelSlot>(objects.first_thing() + i);
    if (object.id == LabelSlot::kUnknown && object.merged_into == LabelSlot::kUnknown) continue;
    const auto extent = extents.find(id);
    const ClassId class_id = objects.class_of(id);
    rows[id] = {object, class_id, probability_of(object, class_id), extent == extents.end() ? LabelExtent{} : extent->second};
  }
  return rows;
}

ObjectTableWriter::ObjectTableWriter(Database& database, double voxel_size_m)
    : voxel_size_m_(voxel_size_m),
      put_(database, kPut),
      remove_(database, "DELETE FROM objects WHERE id = ?"),
      clear_(database, "DELETE FROM objects") {}

void ObjectTableWriter::write(std::map<LabelSlot, ObjectRow> rows) {
  if (!written_) clear_.run();
  const std::map<LabelSlot, ObjectRow> before = std::exchange(written_, std::nullopt).value_or(std::map<LabelSlot, ObjectRow>());
  for (const auto& [id, row] : before) {
    if (!rows.contains(id)) remove_.bind(std::int64_t{number(id)}).run();
  }
  for (const auto& [id, row] : rows) {
    const auto old = before.find(id);
    if (old == before.end() || !(old->second == row)) put(id, row);
  }
  written_ = std::move(rows);
}

void ObjectTableWriter::put(LabelSlot id, const ObjectRow& row) {
  const Object& object = row.object;
  put_.bind(std::int64_t{number(id)});
  if (object.merged_into == LabelSlot::kUnknown) {
    put_.bind_null();
  } else {
    put_.bind(std::int64_t{number(object.merged_into)});
  }
  put_.bind(std::int64_t{number(row.class_id)}).bind(row.probability).bind(object.first_frame).bind(object.last_frame);
  put_.bind(static_cast<std::int64_t>(object.observations)).bind(object.score_sum);
  for (const Json& json : {by_class(object.evidence), classes_json(object.ruled_out), votes_json(object.votes),
                           views_json(object.best_views), parts_json(object.parts)}) {
    put_.bind(std::string_view(json.dump()));
  }
  put_.bind(static_cast<std::int64_t>(row.extent.voxels));
  const ExtentBox box = box_of(row.extent, voxel_size_m_);
  for (const Vec3d& v : {box.center_m, box.min_m, box.max_m}) {
    for (const double coordinate : {v.x(), v.y(), v.z()}) {
      if (row.extent.voxels > 0) {
        put_.bind(coordinate);
      } else {
        put_.bind_null();
      }
    }
  }
  put_.run();
}

std::vector<Object> read_objects(Database& database, std::uint16_t first_thing, std::size_t count) {
  std::vector<Object> objects(count);
  Statement row(database, kSelect);
  const std::int64_t last = first_thing + static_cast<std::int64_t>(count) - 1;
  while (row.step()) {
    const std::int64_t id = row.integer(0, first_thing, last);
    Object& object = objects[static_cast<std::size_t>(id - first_thing)];
    try {
      if (row.is_null(1)) {
        object = object_from(row);
      } else {
        object.merged_into = static_cast<LabelSlot>(row.integer(1, first_thing, last));
      }
    } catch (const RowError&) {
      database.refuse(fmt::format("object {} holds what no object can; the file is damaged: use another copy", id));
    }
  }
  return objects;
}

}  // namespace panoptic
