// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The promise of map.max_weight: however long a surface was looked at, another one outweighs it after ln 2 * max_weight / w
// frames.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "panoptic/voxel_map.h"
#include "tests/fusion/naive_fusion.h"

namespace panoptic {
namespace {

using test::fuse_voxel;
using test::VoxelUpdate;

constexpr float kLimit = 10000;
constexpr int kMany = 1000000;
constexpr float kOldDistance_m = 0.03F;
constexpr float kNewDistance_m = -0.05F;
constexpr std::uint32_t kOldColor = 0xFF282828;
constexpr std::uint32_t kNewColor = 0xFFC8C8C8;
constexpr LabelVotes kVotes{4, 100};

float weight_at(float z_m) { return 1 / (z_m * z_m); }

// A voxel that a million frames saw from 0.3 m.
Voxel old_voxel(LabelSlot label, float max_weight) {
  Voxel voxel;
  for (int i = 0; i < kMany; ++i) {
    fuse_voxel(voxel, {kOldDistance_m, weight_at(0.3F), kOldColor, label}, kVotes, max_weight);
  }
  return voxel;
}

// After how many frames from that distance the new distance, colour and label win.
struct Wins {
  int distance = 0;
  int color = 0;
  int label = 0;
};

Wins frames_until_new_wins(Voxel voxel, float z_m, LabelSlot label, float max_weight = kLimit) {
  constexpr float kHalfWay_m = (kOldDistance_m + kNewDistance_m) / 2;
  constexpr int kHalfWayColor = (0x28 + 0xC8) * 256 / 2;
  Wins wins;
  for (int i = 1; wins.distance == 0 || wins.color == 0 || wins.label == 0; ++i) {
    if (i > kMany) break;
    fuse_voxel(voxel, {kNewDistance_m, weight_at(z_m), kNewColor, label}, kVotes, max_weight);
    if (wins.distance == 0 && voxel.distance < kHalfWay_m) wins.distance = i;
    if (wins.color == 0 && voxel.red > kHalfWayColor) wins.color = i;
    if (wins.label == 0 && voxel.label == number(label)) wins.label = i;
  }
  return wins;
}

TEST(MaxWeight, AnotherSurfaceColourAndLabelWinWhenStatedAfterAMillionFramesOfOne) {
  for (const float z_m : {0.3F, 1.0F, 5.0F}) {
    const double law = std::log(2.0) * double{kLimit} / double{weight_at(z_m)};
    const Voxel stuff = old_voxel(LabelSlot{3}, kLimit);
    ASSERT_EQ(stuff.weight, kLimit);
    ASSERT_EQ(stuff.vote_sum, kLimit);
    const Wins wins = frames_until_new_wins(stuff, z_m, LabelSlot{5});
    EXPECT_NEAR(wins.distance / law, 1, 0.03) << z_m;
    EXPECT_NEAR(wins.label / law, 1, 0.03) << z_m;
    EXPECT_GT(wins.color, 0) << z_m;
    EXPECT_LT(wins.color / law, 1.03) << z_m << ": no later";
    const Voxel object = old_voxel(LabelSlot{100}, kLimit);
    EXPECT_NEAR(frames_until_new_wins(object, z_m, LabelSlot{101}).label / law, 0.25, 0.02) << z_m << ": votes count fourfold";
  }
}

TEST(MaxWeight, WithoutALimitNothingFromAfarChangesAVoxelAnyMore) {
  constexpr float kNone = std::numeric_limits<float>::infinity();
  const Voxel old = old_voxel(LabelSlot{3}, kNone);
  const Wins wins = frames_until_new_wins(old, 5, LabelSlot{5}, kNone);
  EXPECT_EQ(wins.distance, 0);
  EXPECT_EQ(wins.label, 0);
}

TEST(MaxWeight, VotesThatFadeKeepWhatTheySay) {
  Voxel voxel;
  for (int i = 0; i < 300000; ++i) {  // seven frames of ten for one label, three for another
    const auto label = static_cast<LabelSlot>(i % 10 < 7 ? 3 : 5);
    fuse_voxel(voxel, {0, 1, 0, label}, kVotes, kLimit);
    ASSERT_LE(voxel.label_weight, voxel.vote_sum);
  }
  EXPECT_EQ(voxel.label, 3);
  EXPECT_EQ(voxel.vote_sum, kLimit);
  EXPECT_NEAR(label_share(voxel.label_weight, voxel.vote_sum), 0.4, 0.01);
}

TEST(MaxWeight, BelowTheLimitNothingChangesBitForBit) {
  Voxel limited;
  Voxel free;
  for (int i = 0; i < 500; ++i) {
    const VoxelUpdate update{0.001F * static_cast<float>(i % 17), 0.1F + 0.01F * static_cast<float>(i % 7),
                             0xFF000000U + static_cast<std::uint32_t>(i * 7919 % 0xFFFFFF), static_cast<LabelSlot>(i % 3)};
    fuse_voxel(limited, update, kVotes, 100);
    fuse_voxel(free, update, kVotes, std::numeric_limits<float>::infinity());
  }
  ASSERT_LT(free.weight, 100);
  EXPECT_EQ(limited.distance, free.distance);
  EXPECT_EQ(limited.weight, free.weight);
  EXPECT_EQ(limited.red, free.red);
  EXPECT_EQ(limited.label_weight, free.label_weight);
  EXPECT_EQ(limited.vote_sum, free.vote_sum);
}

TEST(MaxWeight, OfNoneAndFramesWithoutWeightLeaveNumbers) {
  const VoxelMap unlimited({0.02F, 4, 0});
  EXPECT_TRUE(std::isinf(unlimited.max_weight()));
  Voxel voxel;
  fuse_voxel(voxel, {0.01F, 1, kOldColor, LabelSlot{3}}, kVotes, unlimited.max_weight());
  const Voxel before = voxel;
  fuse_voxel(voxel, {0.02F, 0, kNewColor, LabelSlot{5}}, kVotes, unlimited.max_weight());
  EXPECT_EQ(voxel.distance, before.distance);
  EXPECT_EQ(voxel.red, before.red) << "a frame without weight moves no colour";
  EXPECT_EQ(voxel.label, before.label);
  EXPECT_EQ(voxel.vote_sum, before.vote_sum);
  const VoxelVotes none = fused_votes({{0, 0}, 0}, 3, 0, unlimited.max_weight());
  EXPECT_EQ(none.label.weight, 0);
  EXPECT_EQ(none.sum, 0);
}

TEST(MaxWeight, AColourMovesByOneUnitAtLeast) {
  constexpr std::int32_t kOld = 30000;
  EXPECT_EQ(fused_color(kOld, kLimit, 200, 0.04F), kOld + 1);
  EXPECT_EQ(fused_color(kOld, kLimit, 20, 0.04F), kOld - 1);
  EXPECT_EQ(fused_color(200 * 256, kLimit, 200, 0.04F), 200 * 256) << "it is there";
  EXPECT_EQ(fused_color(200 * 256 - 1, 1, 200, 0.1F), 200 * 256) << "and no farther";
  EXPECT_EQ(fused_color(kOld, 1, 200, 1), (kOld + 200 * 256) / 2);
}

}  // namespace
}  // namespace panoptic
