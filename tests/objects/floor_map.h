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

namespace panoptic::test {

inline constexpr float kWeight = 10;

// A voxel of the test maps.
struct Voxel {
  std::uint16_t label = 1;
  float label_weight = 8;
  float color = 100;
  float votes = kWeight;
};

using Paint = std::function<Voxel(int x, int y, std::mt19937& random)>;

// A floor of that many voxels a side, 8 voxels thick, between the blocks of two layers.
inline VoxelMap floor_map(int side, const Paint& paint) {
  VoxelMap map({});
  std::mt19937 random(1);
  for (int z = -4; z < 4; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        VoxelBlock& block = map.block(map.allocate({x >> 4, y >> 4, z >> 4}));
        const auto voxel = static_cast<std::size_t>(voxel_offset(x & 15, y & 15, z & 15));
        const Voxel v = paint(x, y, random);
        block.distance[voxel] = (static_cast<float>(z) + 0.5F) * map.voxel_size_m();
        block.weight[voxel] = kWeight;
        block.label[voxel] = v.label;
        block.label_weight[voxel] = v.label_weight;
        block.vote_sum[voxel] = v.votes;
        block.red[voxel] = block.green[voxel] = block.blue[voxel] = static_cast<std::uint16_t>(v.color * 256);
      }
    }
  }
  return map;
}

inline std::vector<std::uint16_t> labels_of(const VoxelMap& map) {
  std::vector<std::uint16_t> labels;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    labels.insert(labels.end(), map.block(slot).label.begin(), map.block(slot).label.end());
  }
  return labels;
}

}  // namespace panoptic::test
