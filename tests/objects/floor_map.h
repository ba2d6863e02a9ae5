// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A painted floor without frames, for the tests of the regularizer.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "panoptic/voxel_map.h"
#include "tests/block_planes.h"

namespace panoptic::test {

inline constexpr float kWeight = 10;

// A voxel of the test maps.
struct PaintedVoxel {
  std::uint16_t label = 1;
  float label_weight = 8;
  float color = 100;
  float votes = kWeight;
};

using Paint = std::function<PaintedVoxel(int x, int y, std::mt19937& random)>;

// A floor of that many voxels a side, 8 voxels thick, between the blocks of two layers.
inline VoxelMap floor_map(int side, const Paint& paint) {
  VoxelMap map({});
  std::mt19937 random(1);
  for (int z = -4; z < 4; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        VoxelBlock& block = map.block(map.allocate({x >> 4, y >> 4, z >> 4}));
        const PaintedVoxel v = paint(x, y, random);
        const float distance_m = (static_cast<float>(z) + 0.5F) * map.voxel_size_m();
        const auto color = static_cast<std::uint16_t>(v.color * 256);
        block.set(voxel_offset(x & 15, y & 15, z & 15),
                  {distance_m, kWeight, v.label_weight, v.votes, v.label, color, color, color});
      }
    }
  }
  return map;
}

inline std::vector<std::uint16_t> labels_of(const VoxelMap& map) {
  std::vector<std::uint16_t> labels;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockPlanes planes = planes_of(map.block(slot));
    labels.insert(labels.end(), planes.label.begin(), planes.label.end());
  }
  return labels;
}

}  // namespace panoptic::test
