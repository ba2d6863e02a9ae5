// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// affordances.json, rooms.json and floorplan.svg (docs/home_plan.md).
#include <cmath>
#include <string>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/base/polygon.h"
#include "panoptic/home_plan.h"
#include "panoptic/planning/plan_files.h"

namespace panoptic {
namespace {

// Tenths of a millimetre are enough for anybody.
double rounded(double value) {
  const double tenths = std::round(value * 1e4) / 1e4;
  return tenths == 0 ? 0 : tenths;  // no -0
}

Json point_json(const Vec3d& p) { return Json::array({rounded(p.x()), rounded(p.y()), rounded(p.z())}); }

Json points_json(const std::vector<Vec3d>& points) {
  Json all = Json::array();
  for (const Vec3d& p : points) all.push_back(point_json(p));
  return all;
}

Json head(const HomePlan& plan) { return {{"unit", "m"}, {"world_from_grid", to_json(Pose(plan.grid_from_world.inverse()))}}; }

Json seats_json(const HomePlan& plan) {
  Json all = Json::array();
  for (const Seat& seat : plan.seats) {
    all.push_back({{"position", point_json(seat.position)},
                   {"normal", point_json(seat.normal)},
                   {"facing", point_json(seat.facing)},
                   {"height_m", rounded(seat.height_m)},
                   {"has_back", seat.has_back},
                   {"object", number(seat.object)}});
  }
  return all;
}

Json lying_places_json(const HomePlan& plan) {
  Json all = Json::array();
  for (const LyingPlace& place : plan.lying_places) {
    all.push_back({{"polygon", points_json(place.polygon)},
                   {"center", point_json(place.center)},
                   {"axis", point_json(place.axis)},
                   {"length_m", rounded(place.length_m)},
                   {"width_m", rounded(place.width_m)},
                   {"height_m", rounded(place.height_m)},
                   {"object", number(place.object)}});
  }
  return all;
}

Json table_tops_json(const HomePlan& plan) {
  Json all = Json::array();
  for (const TableTop& top : plan.table_tops) {
    Json rectangles = Json::array();
    for (const auto& rectangle : top.free_rectangles) rectangles.push_back(points_json(rectangle));
    all.push_back({{"polygon", points_json(top.polygon)},
                   {"free_rectangles", std::move(rectangles)},
                   {"height_m", rounded(top.height_m)},
                   {"area_m2", rounded(top.area_m2)},
                   {"object", number(top.object)}});
  }
  return all;
}

Json doors_json(const HomePlan& plan) {
  Json all = Json::array();
  for (const Opening& door : plan.doors) {
    const Vec3d half = door.along * door.width_m / 2;
    const Vec3d up(0, 0, door.height_m);
    const std::vector<Vec3d> polygon = {door.center - half, door.center + half, door.center + half + up, door.center - half + up};
    Json json = {{"polygon", points_json(polygon)},
                 {"width_m", rounded(door.width_m)},
                 {"height_m", rounded(door.height_m)},
                 {"wall_m", rounded(door.wall_m)},
                 {"open", door.is_open},
                 {"rooms", door.rooms}};
    if (door.leaf != PanopticId::kUnknown) json["object"] = number(door.leaf);
    all.push_back(std::move(json));
  }
  return all;
}

Json rooms_json(const HomePlan& plan) {
  Json all = Json::array();
  for (const MappedRoom& room : plan.rooms) {
    Json polygon = Json::array();
    for (const Vec2d& corner : room.polygon) polygon.push_back(Json::array({rounded(corner.x()), rounded(corner.y())}));
    Json objects = Json::array();
    for (const PanopticId id : room.objects) objects.push_back(number(id));
    all.push_back({{"id", room.id},
                   {"class", room.class_name},
                   {"polygon", std::move(polygon)},
                   {"area_m2", rounded(room.area_m2)},
                   {"objects", std::move(objects)},
                   {"doors", room.doors}});
  }
  return all;
}

}  // namespace

Json affordances_json(const HomePlan& plan) {
  Json affordances = head(plan);
  affordances["seats"] = seats_json(plan);
  affordances["lying_places"] = lying_places_json(plan);
  affordances["table_tops"] = table_tops_json(plan);
  affordances["doors"] = doors_json(plan);
  return affordances;
}

void write_home_plan(const HomePlan& plan, const LabelSet& labels, const std::filesystem::path& folder) {
  write_json_file(folder / "affordances.json", affordances_json(plan));
  Json rooms = head(plan);
  rooms["rooms"] = rooms_json(plan);
  write_json_file(folder / "rooms.json", rooms);
  write_file(folder / "floorplan.svg", floor_plan_svg(plan, labels));
}

}  // namespace panoptic
