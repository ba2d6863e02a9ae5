// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include "panoptic/sim/placement.h"

namespace panoptic {
namespace {

constexpr double kUpperCabinet_m = 1.42;  // bottom above the floor, if the catalogue does not say
constexpr double kInset_m = 0.35;         // a sink less high than this lies in a worktop

// One row along a wall, from `start_m` on; every piece with its back to the wall and touching the one before it.
struct Row {
  Side side;
  double next_m;
  int direction;  // +1 to the right, -1 to the left
};

std::optional<std::size_t> append(RoomLayout& layout, std::string_view role, Row& row) {
  const WallFace face = wall_face(layout.room().floor, row.side);
  for (const std::size_t furniture : layout.candidates(role)) {
    const Furniture& it = layout.catalogue().furniture()[furniture];
    const double center_m = row.next_m + row.direction * static_cast<double>(it.size_m.x()) / 2;
    Stand stand;
    stand.front = face.inward;
    stand.center = face.at(center_m, it.size_m.y() / 2 + 0.01);
    stand.bottom_m = 0;
    FreeZone zone;
    zone.area = {stand.center + face.inward * (it.size_m.y() / 2 + 0.35), {it.size_m.x() / 2.0, 0.33}, face.along};
    zone.high_m = 1.9;
    zone.admits_small = true;
    const auto placed = layout.place(furniture, stand, zone);
    if (!placed) continue;
    row.next_m += row.direction * (static_cast<double>(it.size_m.x()) + 0.004);
    return placed;
  }
  return std::nullopt;
}

// Above what is low enough, centred on it.
void add_upper_cabinets(RoomLayout& layout, const std::vector<std::size_t>& row) {
  std::vector<std::size_t> cabinets = layout.candidates("upper_cabinet");
  for (const std::size_t below : row) {
    const PlacedFurniture base = layout.placements()[below];
    if (base.top_m() > 1.2 || layout.random().chance(0.15)) continue;
    for (const std::size_t cabinet : cabinets) {
      const Furniture& it = layout.catalogue().furniture()[cabinet];
      Stand stand;
      stand.front = base.front();
      stand.center = base.base.center - base.front() * (base.base.half_m.y() - it.size_m.y() / 2);
      stand.bottom_m = std::max<double>(it.elevation_m, kUpperCabinet_m);
      if (layout.place(cabinet, stand)) break;
    }
  }
}

// A sink that is no cabinet of its own goes onto a worktop.
void add_sink(RoomLayout& layout, const std::vector<std::size_t>& row) {
  if (layout.find("kitchen_sink")) return;
  for (const std::size_t sink : layout.candidates("kitchen_sink")) {
    if (layout.catalogue().furniture()[sink].size_m.z() > kInset_m) continue;
    for (const std::size_t below : row) {
      if (layout.furniture(layout.placements()[below]).role != "kitchen_counter") continue;
      const PlacedFurniture top = layout.placements()[below];
      Stand stand;
      stand.front = top.front();
      stand.center = top.base.center;
      stand.bottom_m = top.top_m();
      stand.partner = below;
      if (layout.place(sink, stand)) return;
    }
  }
}

std::vector<std::size_t> build_row(RoomLayout& layout, Row row) {
  std::vector<std::string> roles = {"kitchen_counter", "stove", "kitchen_counter", "base_cabinet"};
  const bool sink_has_a_cabinet = [&] {
    const auto sinks = layout.candidates("kitchen_sink");
    return std::any_of(sinks.begin(), sinks.end(),
                       [&](std::size_t i) { return layout.catalogue().furniture()[i].size_m.z() > kInset_m; });
  }();
  if (sink_has_a_cabinet) roles.insert(roles.begin(), "kitchen_sink");
  if (!layout.find("refrigerator")) roles.insert(roles.begin(), "refrigerator");
  std::vector<std::size_t> placed;
  for (const std::string& role : roles) {
    if (role != "kitchen_counter" && role != "base_cabinet" && layout.find(role)) continue;
    if (const auto piece = append(layout, role, row)) placed.push_back(*piece);
  }
  return placed;
}

}  // namespace

// The row stands at the wall with the longest free stretch from a corner; what does not fit there goes to another wall.
void furnish_kitchen(RoomLayout& layout) {
  std::vector<Side> sides = {Side::kWest, Side::kEast, Side::kSouth, Side::kNorth};
  layout.random().shuffle(sides);
  const auto hindrance = [&](Side side) {
    double hindrance_m = -wall_face(layout.room().floor, side).length_m;
    for (const WallHole& hole : layout.holes()) {
      if (hole.side == side) hindrance_m += hole.kind == Hole::kWindow ? 1.0 : 3.0;
    }
    return hindrance_m;
  };
  std::stable_sort(sides.begin(), sides.end(), [&](Side a, Side b) { return hindrance(a) < hindrance(b); });
  std::vector<std::size_t> row;
  for (const Side side : sides) {
    const bool is_complete =
        layout.find("kitchen_sink") && layout.find("stove") && layout.find("refrigerator") && layout.find("kitchen_counter");
    if (is_complete) break;
    const double length_m = wall_face(layout.room().floor, side).length_m;
    const bool from_left = layout.random().chance(0.5);
    const auto placed = build_row(layout, {side, from_left ? 0.02 : length_m - 0.02, from_left ? 1 : -1});
    row.insert(row.end(), placed.begin(), placed.end());
  }
  add_sink(layout, row);
  add_upper_cabinets(layout, row);
  for (const std::size_t piece : row) {
    const std::string& role = layout.furniture(layout.placements()[piece]).role;
    if (role == "kitchen_counter" || role == "base_cabinet") things_on(layout, "kitchen_item", piece, 2);
  }
  against_wall(layout, "bin", {.free_front_m = 0});
}

}  // namespace panoptic
