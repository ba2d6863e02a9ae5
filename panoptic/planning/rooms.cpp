// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/rooms.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "panoptic/planning/doors.h"

namespace panoptic {
namespace {

constexpr double kShoulders_m = 0.4;    // what is narrower is no way from one part of a room to another
constexpr double kSmallestRoom_m2 = 1;  // a lavatory
constexpr double kDeepest_m = 1.0;      // what stands before a wall and hides it: a wardrobe
constexpr double kCornerCut_m = 0.12;   // detail of the outline that furniture and voxels make

// Where there is room between the walls, be it taken by furniture; doors are shut.
CellSet space_between_walls(const OpenFloor& floor, const HomePlan& plan) {
  constexpr double kOnTheFloor_m = 0.5;
  CellSet space = floor.open;
  for (const ThingFootprint& print : plan.furniture) {
    if (print.low_m < kOnTheFloor_m) add_polygon(floor.grid, print.polygon, space);
  }
  CellSet shut = floor.wall;
  for (const Opening& door : plan.doors) add_polygon(floor.grid, threshold_of(door, 1.5 * floor.grid.cell_m), shut);
  for (std::size_t cell = 0; cell < space.size(); ++cell) {
    if (shut[cell] != 0) space[cell] = 0;
  }
  return space;
}

// Forgets parts that are too small for rooms and numbers the others anew.
void drop_small(const FlatGrid& grid, CellParts& parts) {
  std::map<int, std::size_t> cells;
  for (const int part : parts) ++cells[part];
  std::map<int, int> renamed;
  for (const auto& [part, count] : cells) {
    const bool is_room = part != 0 && static_cast<double>(count) * grid.cell_m * grid.cell_m >= kSmallestRoom_m2;
    if (is_room) renamed.emplace(part, static_cast<int>(renamed.size()) + 1);
  }
  for (int& part : parts) {
    const auto name = renamed.find(part);
    part = name == renamed.end() ? 0 : name->second;
  }
}

// Gives the floor between a wall and what stands before it to the room that the thing stands in.
void fill_to_walls(const OpenFloor& floor, const std::vector<WallLine>& walls, CellParts& parts) {
  const double step_m = floor.grid.cell_m / 2;
  for (const WallLine& wall : walls) {
    const Vec2d along = wall.to - wall.from;
    const int steps = static_cast<int>(along.norm() / step_m) + 1;
    for (int i = 0; i <= steps; ++i) {
      const Vec2d foot = wall.from + along * i / steps;
      std::vector<std::size_t> hidden;
      int room = 0;
      for (double before_m = step_m / 2; before_m < kDeepest_m && room == 0; before_m += step_m) {
        const auto cell = floor.grid.cell_at(foot + wall.normal * before_m);
        if (!cell || (floor.wall[*cell] != 0 && before_m > 3 * step_m)) break;
        room = parts[*cell];
        if (room == 0) hidden.push_back(*cell);
      }
      if (room == 0) continue;
      for (const std::size_t cell : hidden) parts[cell] = room;
    }
  }
}

CellSet grown(const FlatGrid& grid, CellSet set, double radius_m) {
  const auto invert = [](CellSet& cells) {
    for (char& cell : cells) cell = cell != 0 ? 0 : 1;
  };
  invert(set);
  set = shrunk(grid, set, radius_m);
  invert(set);
  return set;
}

// The part without dents narrower than 0.5 m and without spurs narrower than 0.3 m: a room has neither, but voxels make some.
Polygon smooth_outline(const FlatGrid& grid, const CellParts& parts, int part) {
  constexpr double kDent_m = 0.25;
  constexpr double kSpur_m = 0.15;
  CellSet set(grid.size(), 0);
  for (std::size_t cell = 0; cell < set.size(); ++cell) set[cell] = parts[cell] == part ? 1 : 0;
  set = shrunk(grid, grown(grid, std::move(set), kDent_m), kDent_m);
  set = grown(grid, shrunk(grid, set, kSpur_m), kSpur_m);
  return simplified(outline(grid, CellParts(set.begin(), set.end()), 1), kCornerCut_m);
}

// The number of the part at a point or near it.
int part_near(const FlatGrid& grid, const CellParts& parts, const Vec2d& p, double reach_m) {
  const int reach = static_cast<int>(reach_m / grid.cell_m);
  int nearest = 0;
  double nearest_m = reach_m;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const auto cell = grid.cell_at(p + Vec2d(dx, dy) * grid.cell_m);
      if (!cell || parts[*cell] == 0) continue;
      const double distance_m = (grid.middle(*cell) - p).norm();
      if (distance_m < nearest_m) nearest_m = distance_m, nearest = parts[*cell];
    }
  }
  return nearest;
}

void join_doors(const FlatGrid& grid, const CellParts& parts, HomePlan& plan) {
  constexpr double kBeside_m = 0.25;
  for (std::size_t i = 0; i < plan.doors.size(); ++i) {
    Opening& door = plan.doors[i];
    const Vec2d across = quarter_turn(door.along.head<2>());
    for (const int side : {-1, 1}) {
      const Vec2d beside = door.center.head<2>() + across * side * (door.wall_m / 2 + kBeside_m);
      const int part = part_near(grid, parts, beside, kBeside_m);
      if (part == 0 || (!door.rooms.empty() && door.rooms.front() == part - 1)) continue;
      door.rooms.push_back(part - 1);
      plan.rooms[static_cast<std::size_t>(part) - 1].doors.push_back(static_cast<int>(i));
    }
  }
}

void add_objects(const FlatGrid& grid, const CellParts& parts, const LabelSet& labels, HomePlan& plan) {
  constexpr double kReach_m = 0.5;
  std::vector<std::vector<std::string_view>> names(plan.rooms.size());
  for (const ThingFootprint& print : plan.furniture) {
    const int part = part_near(grid, parts, centroid(print.polygon), kReach_m);
    if (part == 0) continue;
    const auto room = static_cast<std::size_t>(part) - 1;
    plan.rooms[room].objects.push_back(print.object);
    names[room].push_back(labels.name_of(print.class_id));
  }
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) plan.rooms[i].class_name = room_class(names[i]);
}

}  // namespace

std::string room_class(const std::vector<std::string_view>& things) {
  const auto has = [&](std::initializer_list<std::string_view> names) {
    return std::any_of(things.begin(), things.end(),
                       [&](std::string_view it) { return std::find(names.begin(), names.end(), it) != names.end(); });
  };
  if (has({"toilet", "bathtub", "shower curtain", "shower"})) return "bathroom";
  const bool has_kitchen = has({"refrigerator", "oven", "stove", "counter", "microwave", "dishwasher"});
  const bool is_studio = has({"bed"}) && has_kitchen;
  if (has({"sofa", "couch"}) || is_studio) return "living room";
  if (has({"bed"})) return "bedroom";
  if (has_kitchen) return "kitchen";
  if (has({"desk", "monitor", "keyboard"})) return "office";
  if (has({"tv", "television", "fireplace"})) return "living room";
  if (has({"table"}) && has({"chair"})) return "dining room";
  if (has({"sink"})) return "bathroom";
  return "room";
}

void add_rooms(const OpenFloor& floor, const LabelSet& labels, HomePlan& plan) {
  const CellSet space = space_between_walls(floor, plan);
  CellParts parts = connected_parts(floor.grid, shrunk(floor.grid, space, kShoulders_m / 2));
  drop_small(floor.grid, parts);
  grow_within(floor.grid, space, parts);
  fill_to_walls(floor, plan.walls, parts);
  const int count = parts.empty() ? 0 : *std::max_element(parts.begin(), parts.end());
  for (int part = 1; part <= count; ++part) {
    MappedRoom room;
    room.id = part - 1;
    room.polygon = on_walls(smooth_outline(floor.grid, parts, part), plan.walls);
    room.area_m2 = signed_area(room.polygon);
    plan.rooms.push_back(std::move(room));
  }
  join_doors(floor.grid, parts, plan);
  add_objects(floor.grid, parts, labels, plan);
}

}  // namespace panoptic
