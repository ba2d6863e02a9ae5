// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/placement.h"

namespace panoptic {
namespace {

// The curtain hangs along the free long side of the tub, above its rim, over half to all of its length.
void hang_shower_curtain(RoomLayout& layout, std::size_t bathtub) {
  const PlacedFurniture tub = layout.placements()[bathtub];
  for (const std::size_t curtain : layout.candidates("shower_curtain")) {
    const Furniture& it = layout.catalogue().furniture()[curtain];
    const bool is_long_in_x = tub.base.half_m.x() > tub.base.half_m.y();
    const Eigen::Vector2d outward =
        is_long_in_x ? tub.front() : (layout.random().chance(0.5) ? tub.base.axis : Eigen::Vector2d(-tub.base.axis));
    const double length_m = 2 * tub.base.half_m.maxCoeff();
    const double half_depth_m = tub.base.half_m.minCoeff();
    for (const Eigen::Vector2d& towards : {outward, Eigen::Vector2d(is_long_in_x ? outward : -outward)}) {
      const double share = layout.random().uniform(0.5, 0.9);
      Stand stand;
      stand.front = towards;
      stand.partner = bathtub;
      stand.scale.x() = static_cast<float>(length_m * share) / it.size_m.x();
      const Eigen::Vector2d along(-towards.y(), towards.x());
      const double play_m = length_m * (1 - share) / 2 - 0.01;
      stand.center = tub.base.center + towards * (half_depth_m + it.size_m.y() / 2 + 0.005) +
                     along * (layout.random().chance(0.5) ? play_m : -play_m);
      if (layout.place(curtain, stand)) return;
    }
  }
}

}  // namespace

void furnish_bathroom(RoomLayout& layout) {
  if (const auto bathtub = against_wall(layout, "bathtub", {.gap_m = 0.01, .free_front_m = 0.55, .in_corner = true})) {
    hang_shower_curtain(layout, *bathtub);
  }
  against_wall(layout, "toilet", {.gap_m = 0.01, .free_front_m = 0.5, .free_sides_m = 0.15});
  if (const auto basin = against_wall(layout, "washbasin", {.gap_m = 0.005, .free_front_m = 0.55})) {
    const bool on_the_left = layout.random().chance(0.5);
    if (!beside(layout, "bathroom_cabinet", *basin, on_the_left) && !beside(layout, "bathroom_cabinet", *basin, !on_the_left)) {
      against_wall(layout, "bathroom_cabinet", {.free_front_m = 0.4});
    }
  }
  if (layout.random().chance(0.6)) against_wall(layout, "washing_machine", {.free_front_m = 0.5, .in_corner = true});
  if (layout.random().chance(0.6)) against_wall(layout, "bin", {.free_front_m = 0});
  for (const char* role : {"bathroom_cabinet", "washing_machine"}) {
    if (const auto carrier = layout.find(role)) {
      if (layout.placements()[*carrier].top_m() < 1.2) things_on(layout, "bathroom_item", *carrier, 2);
    }
  }
}

}  // namespace panoptic
