// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/home_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "panoptic/base/json.h"
#include "panoptic/labels.h"
#include "panoptic/sim/floor_plan.h"
#include "panoptic/sim/model_heights.h"

namespace panoptic {
namespace {

// docs/home_plan.md has the reasons; a planner does not share these, so that neither follows the other's mistakes.
constexpr HeightRange kSeatHeight{0.25, 0.65};
constexpr HeightRange kLyingHeight{0.15, 0.9};
constexpr double kSeatWidth_m = 0.55;
constexpr double kLeastSeat_m2 = 0.04;
constexpr double kLyingLength_m = 1.4;
constexpr double kLyingWidth_m = 0.5;

Vec2d to_world(const SceneObject& object, const Vec2d& at) {
  return (object.world_from_object * Vec3d(at.x(), at.y(), 0)).head<2>();
}

Polygon to_world(const SceneObject& object, Polygon polygon) {
  for (Vec2d& corner : polygon) corner = to_world(object, corner);
  return polygon;
}

void add_seats(const SceneObject& object, const ModelHeights& heights, PlanTruth& truth) {
  const auto seat = level_part(heights, kSeatHeight, kLeastSeat_m2);
  if (!seat) return;
  Eigen::AlignedBox2d area;
  double y_sum_m = 0;
  std::size_t cells = 0;
  for (std::size_t cell = 0; cell < heights.grid.size(); ++cell) {
    if (seat->cells[cell] == 0) continue;
    area.extend(heights.grid.middle(cell));
    y_sum_m += heights.grid.middle(cell).y();
    ++cells;
  }
  const double width_m = area.sizes().x() + heights.grid.cell_m;
  const int places = std::max(1, static_cast<int>(width_m / kSeatWidth_m));
  for (int i = 0; i < places; ++i) {
    const double x = area.center().x() + ((i + 0.5) / places - 0.5) * width_m;
    const Vec2d at = to_world(object, {x, y_sum_m / static_cast<double>(cells)});
    const Vec2d front = -object.world_from_object.linear().col(1).head<2>();
    truth.seats.push_back({{at.x(), at.y(), seat->height_m}, front.normalized(), object.instance});
  }
}

void add_lying_place(const SceneObject& object, const ModelHeights& heights, PlanTruth& truth) {
  const auto level = level_part(heights, kLyingHeight, kLyingLength_m * kLyingWidth_m);
  if (!level) return;
  const Polygon shape = shape_of(heights.grid, level->cells);
  const Vec2d size_m = smallest_box(convex_hull(shape)).size_m;
  if (size_m.x() < kLyingLength_m || size_m.y() < kLyingWidth_m) return;
  truth.lying_places.push_back({to_world(object, shape), level->height_m, object.instance});
}

// The top is all that lies within 1.5 cm of the thing's full height (the catalogue promises that tables are level there).
void add_table_top(const SceneObject& object, const ModelHeights& heights, PlanTruth& truth) {
  constexpr float kLevel_m = 0.015F;
  float top_m = 0;
  for (const float z : heights.top_m) top_m = std::max(top_m, std::isnan(z) ? 0 : z);
  CellSet cells(heights.grid.size(), 0);
  for (std::size_t cell = 0; cell < cells.size(); ++cell) cells[cell] = heights.top_m[cell] >= top_m - kLevel_m ? 1 : 0;
  truth.table_tops.push_back({to_world(object, shape_of(heights.grid, cells)), top_m, object.instance});
}

void add_things(const Scene& scene, PlanTruth& truth) {
  const LabelSet labels = load_label_set("scannet20");
  for (const SceneObject& object : scene.objects) {
    const std::string_view name = labels.name_of(object.class_id);
    if (name == "chair" || name == "sofa") add_seats(object, model_heights(scene, object), truth);
    if (name == "bed" || name == "sofa") add_lying_place(object, model_heights(scene, object), truth);
    if (labels.is_support(object.class_id)) add_table_top(object, model_heights(scene, object), truth);
  }
}

// A doorway is a hole in the walls of both its rooms; the first has it in the truth.
void add_doors(const FloorPlan& plan, PlanTruth& truth) {
  for (const WallHole& hole : plan.holes) {
    const WallFace face = wall_face(plan.rooms[hole.room].floor, hole.side);
    TrueDoor door{face.at(hole.center_m), face.along, hole.width_m, hole.top_m - hole.bottom_m, true, {hole.room}};
    if (hole.kind == Hole::kEntrance) {
      door.center = face.at(hole.center_m, -kOuterWall_m / 2);
      door.is_open = false;
      truth.doors.push_back(std::move(door));
    } else if (hole.kind == Hole::kDoorway && plan.doorways[hole.doorway].room_a == hole.room) {
      door.center = plan.doorways[hole.doorway].center;
      door.rooms.push_back(plan.doorways[hole.doorway].room_b);
      truth.doors.push_back(std::move(door));
    }
  }
}

void add_rooms(const Home& home, PlanTruth& truth) {
  for (const Room& room : home.rooms) {
    const Vec2d& low = room.floor.min();
    const Vec2d& high = room.floor.max();
    TrueRoom it{room.kind, {low, {high.x(), low.y()}, high, {low.x(), high.y()}}, {}};
    for (const SceneObject& object : home.scene.objects) {
      const Vec2d at = object.world_from_object.translation().head<2>();
      if (object.instance != 0 && room.floor.contains(at)) it.things.push_back(object.instance);
    }
    truth.rooms.push_back(std::move(it));
  }
}

Json json_of(const Vec3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json json_of(const Polygon& polygon, std::optional<double> height_m) {
  Json corners = Json::array();
  for (const Vec2d& corner : polygon) {
    corners.push_back(height_m ? Json::array({corner.x(), corner.y(), *height_m}) : Json::array({corner.x(), corner.y()}));
  }
  return corners;
}

Json json_of(const std::vector<TrueLevel>& levels) {
  Json all = Json::array();
  for (const TrueLevel& level : levels) {
    all.push_back(
        {{"polygon", json_of(level.polygon, level.height_m)}, {"height_m", level.height_m}, {"object", level.instance}});
  }
  return all;
}

Json json_of(const TrueDoor& door) {
  const Vec2d half = door.along * door.width_m / 2;
  const auto corner = [&](const Vec2d& at, double z) { return Json::array({at.x(), at.y(), z}); };
  const Vec2d left = door.center - half;
  const Vec2d right = door.center + half;
  return {{"polygon", {corner(left, 0), corner(right, 0), corner(right, door.height_m), corner(left, door.height_m)}},
          {"width_m", door.width_m},
          {"height_m", door.height_m},
          {"open", door.is_open},
          {"rooms", door.rooms}};
}

Json in_world(const char* name) {
  return {{"what", name}, {"unit", "m"}, {"world_from_grid", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}};
}

Json affordances_json(const PlanTruth& truth) {
  Json json = in_world("true seats, lying places, table tops and doors");
  json["seats"] = Json::array();
  for (const TrueSeat& seat : truth.seats) {
    json["seats"].push_back({{"position", json_of(seat.position)},
                             {"facing", json_of(Vec3d(seat.facing.x(), seat.facing.y(), 0))},
                             {"height_m", seat.position.z()},
                             {"object", seat.instance}});
  }
  json["lying_places"] = json_of(truth.lying_places);
  json["table_tops"] = json_of(truth.table_tops);
  json["doors"] = Json::array();
  for (const TrueDoor& door : truth.doors) json["doors"].push_back(json_of(door));
  return json;
}

Json rooms_json(const PlanTruth& truth) {
  Json json = in_world("true rooms");
  json["rooms"] = Json::array();
  for (std::size_t i = 0; i < truth.rooms.size(); ++i) {
    const TrueRoom& room = truth.rooms[i];
    Json doors = Json::array();
    for (std::size_t door = 0; door < truth.doors.size(); ++door) {
      const auto& rooms = truth.doors[door].rooms;
      if (std::find(rooms.begin(), rooms.end(), i) != rooms.end()) doors.push_back(door);
    }
    json["rooms"].push_back({{"id", i},
                             {"class", name_of(room.kind)},
                             {"polygon", json_of(room.polygon, std::nullopt)},
                             {"area_m2", signed_area(room.polygon)},
                             {"objects", room.things},
                             {"doors", doors}});
  }
  return json;
}

}  // namespace

PlanTruth home_truth(const Home& home, const HomeOptions& options) {
  PlanTruth truth;
  add_things(home.scene, truth);
  add_doors(make_floor_plan(options), truth);
  add_rooms(home, truth);
  return truth;
}

void write_home_truth(const PlanTruth& truth, const std::filesystem::path& folder) {
  write_json_file(folder / "affordances_truth.json", affordances_json(truth));
  write_json_file(folder / "rooms_truth.json", rooms_json(truth));
}

const char* name_of(RoomKind kind) {
  switch (kind) {
    case RoomKind::kLivingRoom:
      return "living room";
    case RoomKind::kKitchen:
      return "kitchen";
    case RoomKind::kBedroom:
      return "bedroom";
    case RoomKind::kBathroom:
      return "bathroom";
    case RoomKind::kOffice:
      return "office";
  }
  return "room";
}

}  // namespace panoptic
