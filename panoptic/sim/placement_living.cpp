// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "panoptic/sim/placement.h"

namespace panoptic {
namespace {

Side opposite(Side side) {
  switch (side) {
    case Side::kWest:
      return Side::kEast;
    case Side::kEast:
      return Side::kWest;
    case Side::kSouth:
      return Side::kNorth;
    case Side::kNorth:
      return Side::kSouth;
  }
  return side;
}

Side side_behind(const PlacedFurniture& placement) {
  const Eigen::Vector2d front = placement.front();
  if (std::abs(front.x()) > std::abs(front.y())) return front.x() > 0 ? Side::kWest : Side::kEast;
  return front.y() > 0 ? Side::kSouth : Side::kNorth;
}

// The low table between the sofa and the screen, within reach of who sits.
std::optional<std::size_t> add_coffee_table(RoomLayout& layout, std::size_t sofa) {
  const PlacedFurniture seat = layout.placements()[sofa];
  for (const std::size_t table : layout.candidates("coffee_table")) {
    const Vec3d half_m = layout.catalogue().furniture()[table].size_m.cast<double>() / 2;
    Stand stand;
    stand.front = half_m.x() >= half_m.y() ? seat.front() : seat.base.axis;
    const double depth_m = std::min(half_m.x(), half_m.y());
    stand.center = seat.base.center + seat.front() * (seat.base.half_m.y() + 0.38 + depth_m) +
                   seat.base.axis * layout.random().uniform(-0.15, 0.15);
    if (const auto placed = layout.place(table, stand)) return placed;
  }
  return std::nullopt;
}

// The screen stands opposite the sofa if there is a place, else at any wall.
void add_screen(RoomLayout& layout, std::optional<std::size_t> sofa) {
  std::optional<std::size_t> low_board;
  if (sofa) {
    const PlacedFurniture seat = layout.placements()[*sofa];
    const Side side = opposite(side_behind(seat));
    const WallFace face = wall_face(layout.room().floor, side);
    const double center_m = (seat.base.center - face.start).dot(face.along);
    for (const double aside_m : {0.0, 0.25, -0.25, 0.5, -0.5}) {
      if (!low_board)
        low_board = against_wall(layout, "tv_stand", {.free_front_m = 0.5, .side = side, .center_m = center_m + aside_m});
    }
    if (!low_board) low_board = against_wall(layout, "tv_stand", {.free_front_m = 0.5, .side = side});
  }
  if (!low_board) low_board = against_wall(layout, "tv_stand", {.free_front_m = 0.5});
  if (!low_board) return;
  const PlacedFurniture board = layout.placements()[*low_board];
  for (const std::size_t screen : layout.candidates("tv")) {
    Stand stand;
    stand.front = board.front();
    stand.center = board.base.center;
    stand.bottom_m = board.top_m();
    stand.partner = *low_board;
    if (layout.place(screen, stand)) return;
  }
}

// An armchair at an end of the coffee table, turned towards it.
void add_armchair(RoomLayout& layout, std::size_t coffee_table) {
  const PlacedFurniture table = layout.placements()[coffee_table];
  for (const std::size_t chair : layout.candidates("armchair")) {
    const double half_depth_m = layout.catalogue().furniture()[chair].size_m.y() / 2;
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector2d outward = table.base.axis * sign;
      Stand stand;
      stand.center = table.base.center + outward * (table.base.half_m.x() + 0.35 + half_depth_m);
      stand.front = Eigen::Rotation2Dd(layout.random().uniform(-0.35, 0.35)) * -outward;
      if (layout.place(chair, stand)) return;
    }
  }
}

}  // namespace

void furnish_living_room(RoomLayout& layout) {
  const auto sofa = against_wall(layout, "sofa", {.gap_m = 0.04, .free_front_m = 0.34, .free_sides_m = 0.25});
  std::optional<std::size_t> coffee_table;
  if (sofa) coffee_table = add_coffee_table(layout, *sofa);
  add_screen(layout, sofa);
  if (coffee_table) {
    things_on(layout, "table_item", *coffee_table, 2);
    if (layout.random().chance(0.6)) add_armchair(layout, *coffee_table);
  }
  furnish_dining(layout);
  if (sofa && layout.random().chance(0.5)) {
    const auto table = beside(layout, "side_table", *sofa, layout.random().chance(0.5));
    if (table) things_on(layout, "desk_lamp", *table, 1);
  }
  against_wall(layout, "bookshelf", {.free_front_m = 0.5});
  if (layout.random().chance(0.5)) {
    if (const auto dresser = against_wall(layout, "dresser", {.free_front_m = 0.5})) things_on(layout, "table_item", *dresser, 2);
  }
  against_wall(layout, "floor_lamp", {.gap_m = 0.06, .free_front_m = 0, .in_corner = true});
  against_wall(layout, "floor_plant", {.gap_m = 0.06, .free_front_m = 0, .in_corner = true});
}

// A table with as much room around it as the floor gives.
void furnish_dining(RoomLayout& layout) {
  std::optional<std::size_t> table;
  for (const double free_around_m : {0.95, 0.8, 0.65, 0.45}) {
    if (!table) table = in_the_open(layout, "dining_table", free_around_m);
  }
  if (!table) return;
  chairs_at(layout, "dining_chair", *table, layout.random().integer(3, 6));
  things_on(layout, "table_item", *table, 3);
}

}  // namespace panoptic
