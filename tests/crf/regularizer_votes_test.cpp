// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The regularizer takes votes for evidence, and nothing else.
#include <gtest/gtest.h>

#include "panoptic/crf/regularizer.h"
#include "tests/fusion/naive_fusion.h"
#include "tests/objects/floor_map.h"

namespace panoptic {
namespace {

using test::floor_map;
using test::kWeight;
using test::labels_of;
using test::PaintedVoxel;

// A square of 13 x 13 voxels on the floor, 4 deep; this much of the weight are votes, all for what the voxel holds but for
// those that were against it.
VoxelMap square_map(float votes, float against = 0) {
  return floor_map(48, [=](int x, int y, std::mt19937&) {
    const bool square = x >= 18 && x < 31 && y >= 18 && y < 31;
    return PaintedVoxel{static_cast<std::uint16_t>(square ? 2 : 1), votes - (square ? 2 * against : 0), 100, votes};
  });
}

int voxels_of_square(const VoxelMap& map) {
  int count = 0;
  for (int z = -2; z < 2; ++z) {
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 48; ++x) {
        const VoxelBlock* block = map.find({x >> 4, y >> 4, z >> 4});
        count += block->label(voxel_offset(x & 15, y & 15, z & 15)) == 2 ? 1 : 0;
      }
    }
  }
  return count;
}

TEST(Regularizer, WhatEveryVoteAgreedOnStaysHoweverFewFramesAreLabelled) {
  for (const float share : {1.0F, 0.3F, 0.1F}) {
    VoxelMap map = square_map(share * kWeight);
    Regularizer(RegularizerOptions{}, map).run(map);
    EXPECT_EQ(voxels_of_square(map), 676) << share;
  }
  VoxelMap contested = square_map(kWeight, 0.35F * kWeight);
  Regularizer(RegularizerOptions{}, contested).run(contested);
  EXPECT_LT(voxels_of_square(contested), 676) << "votes against it are evidence";
}

TEST(Regularizer, VotesThatCountFourfoldMakeNoLabelSurerThanTheyAre) {
  VoxelMap map({});
  VoxelBlock& block = map.block(map.allocate({0, 0, 0}));
  Voxel voxel;
  constexpr LabelVotes kVotes{4, 100};
  for (int i = 0; i < 10; ++i) {  // four in ten for an object
    test::fuse_voxel(voxel, {0, 1, 0, static_cast<LabelSlot>(i % 5 < 2 ? 100 : 3)}, kVotes, map.max_weight());
  }
  ASSERT_EQ(voxel.label, 100);
  block.set(0, voxel);
  Regularizer regularizer(RegularizerOptions{}, map);
  const TileGraph tile = regularizer.gather(map, {0});
  ASSERT_EQ(tile.graph.size(), 1U);
  EXPECT_FLOAT_EQ(tile.graph.probabilities[0], 0.5F * (1 + (16.0F - 6) / (16 + 6)));
}

// A strip of the floor that frames voted on, and the rest that they never did.
VoxelMap half_voted(std::uint16_t rest) {
  return floor_map(64, [=](int x, int, std::mt19937&) {
    return x < 32 ? PaintedVoxel{7, 6, 100, 6} : PaintedVoxel{rest, 0, 100, 0};
  });
}

TEST(Regularizer, VoxelsWithoutAVoteTakeALabelOnlyNearVotesAndWithoutWeight) {
  VoxelMap map = half_voted(0);
  Regularizer regularizer(RegularizerOptions{}, map);
  EXPECT_GT(regularizer.run(map), 0U);
  int near = 0;
  for (int x = 0; x < 64; ++x) {
    const VoxelBlock* block = map.find({x >> 4, 1, 0});
    const int voxel = voxel_offset(x & 15, 8, 0);
    if (x < 32) {
      ASSERT_EQ(block->label(voxel), 7);
      continue;
    }
    near += block->label(voxel) == 7 ? 1 : 0;
    ASSERT_EQ(block->label_weight(voxel), 0);
    ASSERT_TRUE(x < 56 || block->label(voxel) == 0) << "far from all votes";
  }
  EXPECT_GE(near, 1);
  EXPECT_LE(near, 20);
  const std::vector<std::uint16_t> once = labels_of(map);
  map.begin_epoch();
  for (Slot slot = 0; slot < map.block_count(); ++slot) map.mark_changed(slot);
  EXPECT_EQ(regularizer.run(map), 0U);
  EXPECT_EQ(labels_of(map), once) << "what was filled in is no evidence";
}

TEST(Regularizer, WithoutAnyVoteNothingIsWritten) {
  VoxelMap map = floor_map(48, [](int x, int y, std::mt19937&) {
    return PaintedVoxel{static_cast<std::uint16_t>((x / 7 + y / 5) % 4), 0, 100, 0};
  });
  const std::uint64_t hash = map.hash();
  EXPECT_EQ(Regularizer(RegularizerOptions{}, map).run(map), 0U);
  EXPECT_EQ(map.hash(), hash);
}

}  // namespace
}  // namespace panoptic
