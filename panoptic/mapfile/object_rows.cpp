// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/object_rows.h"

#include <optional>
#include <utility>

#include "panoptic/base/json.h"

namespace panoptic {
namespace {

constexpr const char* kPut =
    "INSERT OR REPLACE INTO objects(id, slot, class_id, probability, first_frame, last_frame, observations, score_sum, evidence, "
    "ruled_out, votes, best_views, parts, voxels, x_m, y_m, z_m, min_x_m, min_y_m, min_z_m, max_x_m, max_y_m, max_z_m) "
    "VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)";
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

Json parts_json(const PartHistory& parts) {
  Json list = Json::array();
  for (const ObjectPart& part : parts.latest()) list.push_back({number(part.id), part.frame});
  return {{"count", parts.count()}, {"latest", std::move(list)}};
}

Json classes_json(const std::set<ClassId>& classes) {
  Json list = Json::array();
  for (const ClassId id : classes) list.push_back(number(id));
  return list;
}

}  // namespace

ObjectRows object_rows(const ObjectRegistry& objects, const LabelExtents& extents) {
  ObjectRows rows;
  for (const Object& object : objects.state().objects) {
    if (object.id == PanopticId::kUnknown) continue;
    const auto extent = extents.find(object.slot);
    const ClassId class_id = objects.class_of(object.slot);
    rows[object.id] = {object, class_id, probability_of(object, class_id),
                       extent == extents.end() ? LabelExtent{} : extent->second};
  }
  return rows;
}

ObjectTableWriter::ObjectTableWriter(Database& database, double voxel_size_m)
    : database_(database),
      voxel_size_m_(voxel_size_m),
      put_(database, kPut),
      remove_(database, "DELETE FROM objects WHERE id = ?") {}

void ObjectTableWriter::write(ObjectRows rows, const RegistryState& registry) {
  if (!written_) database_.execute("DELETE FROM objects; DELETE FROM merged; DELETE FROM left_slots;");
  const Written before = std::exchange(written_, std::nullopt).value_or(Written());
  for (const auto& [id, row] : before.rows) {
    if (!rows.contains(id)) remove_.bind(std::int64_t{number(id)}).run();
  }
  for (const auto& [id, row] : rows) {
    const auto old = before.rows.find(id);
    if (old == before.rows.end() || !(old->second == row)) put(id, row);
  }
  put_merged(registry.merged, before.merged);
  if (registry.left != before.left) put_left(registry.left);
  written_ = {std::move(rows), registry.merged, registry.left};
}

// No merged object is ever forgotten, but what it was merged into may have been merged since.
void ObjectTableWriter::put_merged(const std::vector<MergedObject>& merged, const std::vector<MergedObject>& before) {
  Statement put(database_, "INSERT OR REPLACE INTO merged(id, merged_into) VALUES(?, ?)");
  auto old = before.begin();
  for (const MergedObject& m : merged) {
    while (old != before.end() && old->id < m.id) ++old;
    if (old != before.end() && *old == m) continue;
    put.bind(std::int64_t{number(m.id)}).bind(std::int64_t{number(m.into)}).run();
  }
}

void ObjectTableWriter::put_left(const std::vector<LeftSlot>& left) {
  database_.execute("DELETE FROM left_slots;");
  Statement put(database_, "INSERT INTO left_slots(slot, id) VALUES(?, ?)");
  for (const LeftSlot& l : left) put.bind(std::int64_t{number(l.slot)}).bind(std::int64_t{number(l.id)}).run();
}

void ObjectTableWriter::put(PanopticId id, const ObjectRow& row) {
  const Object& object = row.object;
  put_.bind(std::int64_t{number(id)}).bind(std::int64_t{number(object.slot)});
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

}  // namespace panoptic
