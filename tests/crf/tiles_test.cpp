// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <set>

namespace panoptic {
namespace {

// An L of two plates and a block apart; allocated in the order given by a step through them.
VoxelMap plates(std::size_t step) {
  std::vector<BlockIndex> blocks;
  for (int a = 0; a < 9; ++a) {
    for (int b = 0; b < 9; ++b) {
      blocks.push_back({a, b, 0});
      if (a > 0) blocks.push_back({0, b, a});
    }
  }
  blocks.push_back({-50, 0, 0});
  VoxelMap map({});
  for (std::size_t i = 0, at = 0; i < blocks.size(); ++i, at = (at + step) % blocks.size()) map.allocate(blocks[at]);
  return map;
}

std::vector<Slot> all_slots(const VoxelMap& map) {
  std::vector<Slot> slots(map.block_count());
  std::iota(slots.begin(), slots.end(), Slot{0});
  return slots;
}

bool hangs_together(const VoxelMap& map, const std::vector<Slot>& tile) {
  std::set<Slot> reached = {tile[0]};
  for (std::size_t before = 0; before != reached.size();) {
    before = reached.size();
    for (const Slot slot : tile) {
      for (const Slot other : std::vector<Slot>(reached.begin(), reached.end())) {
        const BlockIndex a = map.index_of(slot);
        const BlockIndex b = map.index_of(other);
        if (std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z) == 1) reached.insert(slot);
      }
    }
  }
  return reached.size() == tile.size();
}

TEST(MapDivision, EveryBlockIsInOneTileOfLimitedSizeThatHangsTogether) {
  const VoxelMap map = plates(1);
  const auto tiles = divide_into_tiles(map, all_slots(map), 25);
  std::vector<Slot> all;
  for (const auto& tile : tiles) {
    EXPECT_LE(tile.size(), 25U);
    EXPECT_TRUE(hangs_together(map, tile));
    all.insert(all.end(), tile.begin(), tile.end());
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, all_slots(map));
}

TEST(MapDivision, DependsOnThePlacesOfTheBlocksNotOnTheirOrder) {
  const VoxelMap a = plates(1);
  const VoxelMap b = plates(5);
  const auto of_a = divide_into_tiles(a, all_slots(a), 10);
  const auto of_b = divide_into_tiles(b, all_slots(b), 10);
  ASSERT_EQ(of_a.size(), of_b.size());
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    ASSERT_EQ(of_a[i].size(), of_b[i].size());
    for (std::size_t k = 0; k < of_a[i].size(); ++k) EXPECT_EQ(a.index_of(of_a[i][k]), b.index_of(of_b[i][k]));
  }
}

TEST(MapDivision, ZeroIsOneTileAndOneIsABlockEach) {
  const VoxelMap map = plates(1);
  EXPECT_EQ(divide_into_tiles(map, all_slots(map), 0).size(), 1U);
  EXPECT_EQ(divide_into_tiles(map, all_slots(map), 1).size(), map.block_count());
  EXPECT_TRUE(divide_into_tiles(map, {}, 25).empty());
}

}  // namespace
}  // namespace panoptic
