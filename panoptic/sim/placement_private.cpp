// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Bedrooms and offices.
#include "panoptic/sim/placement.h"

namespace panoptic {
namespace {

// The desk with its chair and what people put on it.
void add_desk(RoomLayout& layout) {
  const auto desk = against_wall(layout, "desk", {.free_front_m = 0.85});
  if (!desk) return;
  chair_before(layout, "office_chair", *desk);
  const PlacedFurniture top = layout.placements()[*desk];
  for (const std::size_t monitor : layout.candidates("monitor")) {
    const Furniture& it = layout.catalogue().furniture()[monitor];
    Stand stand;
    stand.front = top.front();
    stand.center = top.base.center - top.front() * std::max(0.0, top.base.half_m.y() - it.size_m.y() / 2 - 0.06);
    stand.bottom_m = top.top_m();
    stand.partner = *desk;
    if (layout.place(monitor, stand)) break;
  }
  if (layout.random().chance(0.7)) things_on(layout, "desk_lamp", *desk, 1);
  things_on(layout, "desk_item", *desk, 3);
}

}  // namespace

void furnish_bedroom(RoomLayout& layout) {
  auto bed = layout.random().chance(0.75) ? against_wall(layout, "double_bed", {.free_front_m = 0.5, .free_sides_m = 0.5})
                                          : std::nullopt;
  if (!bed) bed = against_wall(layout, "single_bed", {.free_front_m = 0.3, .in_corner = true});
  if (!bed) bed = against_wall(layout, "single_bed", {.free_front_m = 0});
  if (bed) {
    for (const bool on_the_left : {true, false}) {
      const auto nightstand = beside(layout, "nightstand", *bed, on_the_left);
      if (nightstand && layout.random().chance(0.8)) things_on(layout, "desk_lamp", *nightstand, 1);
    }
  }
  against_wall(layout, "wardrobe", {.free_front_m = 0.6, .in_corner = true});
  if (layout.random().chance(0.6)) {
    if (const auto dresser = against_wall(layout, "dresser", {.free_front_m = 0.5})) things_on(layout, "table_item", *dresser, 2);
  }
  if (layout.room().kind != RoomKind::kBedroom) return;
  if (layout.random().chance(0.5)) add_desk(layout);
  if (layout.random().chance(0.4)) against_wall(layout, "armchair", {.gap_m = 0.08, .free_front_m = 0.4, .in_corner = true});
  if (layout.random().chance(0.4)) against_wall(layout, "bookshelf", {.free_front_m = 0.5});
  if (layout.random().chance(0.5)) against_wall(layout, "floor_plant", {.gap_m = 0.06, .free_front_m = 0, .in_corner = true});
}

void furnish_office(RoomLayout& layout) {
  add_desk(layout);
  const bool is_office = layout.room().kind == RoomKind::kOffice;
  for (int i = 0; i < (is_office ? 2 : 1); ++i) against_wall(layout, "bookshelf", {.free_front_m = 0.5});
  if (!is_office) return;
  if (layout.random().chance(0.5)) add_desk(layout);
  if (layout.random().chance(0.6)) against_wall(layout, "dresser", {.free_front_m = 0.5});
  if (layout.random().chance(0.5)) against_wall(layout, "armchair", {.gap_m = 0.08, .free_front_m = 0.4, .in_corner = true});
  if (layout.random().chance(0.6)) against_wall(layout, "floor_plant", {.gap_m = 0.06, .free_front_m = 0, .in_corner = true});
  if (layout.random().chance(0.6)) against_wall(layout, "floor_lamp", {.gap_m = 0.06, .free_front_m = 0, .in_corner = true});
  against_wall(layout, "bin", {.free_front_m = 0});
}

}  // namespace panoptic
