// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Rules for furniture that hangs on walls or belongs to windows.
#include <algorithm>

#include "panoptic/sim/placement.h"

namespace panoptic {
namespace {

constexpr double kFrontOfRadiator_m = 0.02;

bool has_curtain(const RoomLayout& layout, const WallHole& window) {
  const WallFace face = wall_face(layout.room().floor, window.side);
  return std::any_of(layout.placements().begin(), layout.placements().end(), [&](const PlacedFurniture& placement) {
    if (layout.furniture(placement).role != "curtain") return false;
    const Eigen::Vector2d offset = placement.base.center - face.start;
    return std::abs(offset.dot(face.along) - window.center_m) < window.width_m / 2 + 0.6 && offset.dot(face.inward) < 0.3;
  });
}

// Both halves drawn to the sides of the window; a little of each before the glass.
void hang_pair(RoomLayout& layout, std::size_t curtain, const WallHole& window) {
  const WallFace face = wall_face(layout.room().floor, window.side);
  const Furniture& it = layout.catalogue().furniture()[curtain];
  const double width_m = std::min<double>(it.size_m.x(), 0.55);
  for (const double sign : {-1.0, 1.0}) {
    Stand stand;
    stand.front = face.inward;
    stand.scale.x() = static_cast<float>(width_m) / it.size_m.x();
    stand.bottom_m = 0.03;
    stand.scale.z() = static_cast<float>(window.top_m + 0.12 - 0.03) / it.size_m.z();
    stand.center = face.at(window.center_m + sign * (window.width_m + width_m) / 2 + sign * 0.002, 0.03 + it.size_m.y() / 2);
    layout.place(curtain, stand);
  }
}

}  // namespace

void hang_curtains(RoomLayout& layout, double probability) {
  for (const WallHole& window : layout.holes()) {
    if (window.kind != Hole::kWindow || has_curtain(layout, window) || !layout.random().chance(probability)) continue;
    const std::vector<std::size_t> curtains = layout.candidates("curtain");
    if (!curtains.empty()) hang_pair(layout, curtains[0], window);
  }
}

void add_radiators(RoomLayout& layout) {
  for (const WallHole& window : layout.holes()) {
    if (window.kind != Hole::kWindow || !layout.random().chance(0.7)) continue;
    against_wall(layout, "radiator",
                 {.gap_m = kFrontOfRadiator_m, .free_front_m = 0, .side = window.side, .center_m = window.center_m});
  }
}

void hang_pictures(RoomLayout& layout, int most) {
  const std::vector<std::size_t> pictures = layout.candidates("wall_picture");
  int hung = 0;
  for (int i = 0; i < 6 * most && hung < most && !pictures.empty(); ++i) {
    const std::size_t picture = pictures[static_cast<std::size_t>(hung) % pictures.size()];
    const Furniture& it = layout.catalogue().furniture()[picture];
    const auto side = static_cast<Side>(layout.random().integer(0, 3));
    const WallFace face = wall_face(layout.room().floor, side);
    const double margin_m = it.size_m.x() / 2.0 + 0.2;
    if (face.length_m < 2 * margin_m) continue;
    Stand stand;
    stand.front = face.inward;
    stand.center = face.at(layout.random().uniform(margin_m, face.length_m - margin_m), it.size_m.y() / 2 + 0.002);
    stand.bottom_m = layout.random().uniform(1.4, 1.6) - it.size_m.z() / 2;  // the middle at the height of eyes
    const FloorRect around = {stand.center, {it.size_m.x() / 2 + 0.1, it.size_m.y() / 2}, face.along};
    if (!layout.is_free(around, *stand.bottom_m - 0.05, *stand.bottom_m + it.size_m.z() + 0.05)) continue;
    if (layout.place(picture, stand)) ++hung;
  }
}

}  // namespace panoptic
