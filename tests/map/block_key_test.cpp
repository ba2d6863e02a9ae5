// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/voxel_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "panoptic/map/block_key.h"

namespace panoptic {
namespace {

std::vector<BlockIndex> samples() {
  std::mt19937 random(4);
  std::uniform_int_distribution<std::int32_t> any(-kMaxBlockCoordinate, kMaxBlockCoordinate);
  std::uniform_int_distribution<std::int32_t> near(-3, 3);
  std::vector<BlockIndex> indices = {{0, 0, 0},
                                     {kMaxBlockCoordinate, kMaxBlockCoordinate, kMaxBlockCoordinate},
                                     {-kMaxBlockCoordinate, -kMaxBlockCoordinate, -kMaxBlockCoordinate}};
  for (int i = 0; i < 500; ++i) indices.push_back({any(random), any(random), any(random)});
  for (int i = 0; i < 500; ++i) indices.push_back({near(random), near(random), near(random)});
  return indices;
}

TEST(BlockIndex, UnpackIsTheInverseOfPack) {
  for (const BlockIndex index : samples()) ASSERT_EQ(unpack(pack(index)), index);
}

TEST(BlockIndex, KeysAreInTheOrderOfZThenYThenX) {
  const std::vector<BlockIndex> indices = samples();
  for (std::size_t i = 1; i < indices.size(); ++i) {
    const BlockIndex a = indices[i - 1];
    const BlockIndex b = indices[i];
    ASSERT_EQ(pack(a) < pack(b), std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x));
  }
}

TEST(BlockIndex, KeysLeaveRoomForThePlusOneOfTheTable) {
  const BlockIndex last{kMaxBlockCoordinate, kMaxBlockCoordinate, kMaxBlockCoordinate};
  EXPECT_LT(pack(last), std::numeric_limits<std::uint64_t>::max());
}

TEST(BlockIndex, KnowsItsRange) {
  EXPECT_TRUE(in_range({kMaxBlockCoordinate, -kMaxBlockCoordinate, 0}));
  for (const std::int32_t outside : {kMaxBlockCoordinate + 1, -kMaxBlockCoordinate - 1, std::numeric_limits<std::int32_t>::max(),
                                     std::numeric_limits<std::int32_t>::min()}) {
    EXPECT_FALSE(in_range({outside, 0, 0}));
    EXPECT_FALSE(in_range({0, outside, 0}));
    EXPECT_FALSE(in_range({0, 0, outside}));
  }
}

TEST(BlockIndex, MixedKeysOfNeighboursSpreadOverATable) {
  constexpr std::uint64_t kMask = 4095;
  std::set<std::uint64_t> places;
  int blocks = 0;
  for (std::int32_t z = 0; z < 10; ++z) {
    for (std::int32_t y = 0; y < 10; ++y) {
      for (std::int32_t x = 0; x < 10; ++x, ++blocks) places.insert(mixed(pack({x, y, z})) & kMask);
    }
  }
  // 1000 balls in 4096 boxes fill about 888 boxes when thrown at random.
  EXPECT_GT(places.size(), 850U);
}

}  // namespace
}  // namespace panoptic
