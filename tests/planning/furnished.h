// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map of two rooms with a doorway and furniture, in any rotation, whose walkable floor is known exactly.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "panoptic/map.h"
#include "tests/fusion/small_maps.h"

namespace panoptic::test {

inline constexpr LabelSlot kWallSlot = pid(1);
inline constexpr LabelSlot kFloorSlot = pid(2);
inline constexpr LabelSlot kChairSlot = pid(4);  // an object: the first thing

struct Block {
  Vec3d low;
  Vec3d high;
  LabelSlot label;
};

// Rooms from x = -2 to 0 and from 0.1 to 2, y from -1.5 to 1.5; the doorway is between y = 0.3 and 1.2. A chair of one metre
// stands in the second room, a shelf hangs over the floor of the first, and a rug lies there.
inline std::vector<Block> furniture() {
  return {{{-2.2, -1.7, -0.3}, {2.2, 1.7, 0}, kFloorSlot}, {{-2.2, -1.7, -0.3}, {-2, 1.7, 1.9}, kWallSlot},
          {{2, -1.7, -0.3}, {2.2, 1.7, 1.9}, kWallSlot},   {{-2.2, -1.7, -0.3}, {2.2, -1.5, 1.9}, kWallSlot},
          {{-2.2, 1.5, -0.3}, {2.2, 1.7, 1.9}, kWallSlot}, {{0, -1.5, -0.3}, {0.2, 0.3, 1.9}, kWallSlot},
          {{0, 1.2, -0.3}, {0.2, 1.5, 1.9}, kWallSlot},    {{1.1, -0.9, 0}, {1.5, -0.5, 1}, kChairSlot},
          {{-2, -1.5, 1.1}, {-1.5, -0.7, 1.3}, kWallSlot}, {{-1.3, 0.4, 0}, {-0.6, 1.1, 0.02}, kWallSlot}};
}

// True if a cylinder of this radius may stand with its axis there.
inline bool may_stand(const Eigen::Vector2d& at, double radius_m, double height_m = 1.5, double climb_m = 0.05) {
  if (std::abs(at.x()) > 2 - radius_m || std::abs(at.y()) > 1.5 - radius_m) return false;
  for (const Block& block : furniture()) {
    if (block.high.z() <= climb_m || block.low.z() >= height_m) continue;
    const Eigen::Vector2d away = (block.low.head<2>() - at).cwiseMax(at - block.high.head<2>()).cwiseMax(0.0);
    if (away.norm() < radius_m) return false;
  }
  return true;
}

// The rooms, turned by `world_from_room`.
inline PanopticMap furnished_map(const Pose& world_from_room = Pose::Identity(), float voxel_m = 0.024F) {
  const LabelSet labels("test", {{ClassId{1}, "wall", false, {200, 0, 0}},
                                 {ClassId{2}, "floor", false, {0, 200, 0}},
                                 {ClassId{3}, "chair", true, {0, 0, 200}}});
  PanopticMap map({.voxel_size_m = voxel_m}, labels);
  const auto chair = map.objects.create();
  map.objects.observe(*chair, {ClassId{3}, 1, {{ClassId{3}, 1.0F}}}, 0);
  std::vector<Solid> solids;
  const Pose room_from_world = world_from_room.inverse();
  Eigen::AlignedBox3d extent;
  for (const Block& block : furniture()) {
    const Solid box = solid_box(block.low, block.high, block.label);
    solids.push_back({[=](const Vec3d& p) { return box.distance_m(room_from_world * p); }, block.label});
    for (int n = 0; n < 8; ++n) {
      const Vec3d corner((n & 1) != 0 ? 2.05 : -2.05, (n & 2) != 0 ? 1.55 : -1.55, (n & 4) != 0 ? 1.8 : -0.1);
      extent.extend(world_from_room * corner);
    }
  }
  add_solids(map.voxels, solids, extent.min(), extent.max());
  return map;
}

}  // namespace panoptic::test
