// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/frame_votes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "panoptic/crf/regularizer.h"
#include "panoptic/objects/relabelling.h"
#include "tests/block_planes.h"
#include "tests/objects/maintained_world.h"

namespace panoptic {
namespace {

using test::pid;

TEST(FrameVotes, FramesThatComeAfterwardsCountFromTheVoteNotFromWhatWasWritten) {
  const OverruledVote vote{5, {.label = 7, .weight = 4}, {.label = 1, .weight = 3}};
  const auto since = [&](std::uint16_t label, float weight) {
    const VoxelLabel v = voted_since(vote, {.label = label, .weight = weight});
    return std::pair(v.label, v.weight);
  };
  EXPECT_EQ(since(1, 3), std::pair(std::uint16_t{7}, 4.0F)) << "no frame";
  EXPECT_EQ(since(1, 5), std::pair(std::uint16_t{7}, 2.0F)) << "2 for what was written";
  EXPECT_EQ(since(1, 9), std::pair(std::uint16_t{1}, 2.0F)) << "6 for what was written";
  EXPECT_EQ(since(1, 1), std::pair(std::uint16_t{7}, 6.0F)) << "2 against it";
  EXPECT_EQ(since(7, 2), std::pair(std::uint16_t{7}, 9.0F)) << "5 for the vote";
  EXPECT_EQ(since(9, 2), std::pair(std::uint16_t{9}, 1.0F)) << "5 for a third label";
}

TEST(FrameVotes, ForVoxelsThatAreNoLongerStoredAreForgotten) {
  FrameVotes votes;
  const auto voxel = [](int brick, int n) { return static_cast<std::uint16_t>(offset_in_block(brick, n)); };
  for (const std::uint16_t v : {voxel(2, 5), voxel(2, 6), voxel(3, 5)}) votes.record(1, {v, {7, 4}, {1, 3}});
  votes.forget(1, 2, std::uint64_t{1} << 5);
  votes.forget(9, 2, ~std::uint64_t{0});
  ASSERT_EQ(votes.of(1).size(), 2U);
  EXPECT_EQ(votes.voted(1, voxel(2, 5), {0, 0}).label, 0);
  EXPECT_EQ(votes.voted(1, voxel(2, 6), {1, 3}).label, 7);
  EXPECT_EQ(votes.voted(1, voxel(3, 5), {1, 3}).label, 7);
}

TEST(FrameVotes, AreKeptInOrderAndForgottenOnceTheyHold) {
  FrameVotes votes;
  EXPECT_TRUE(votes.of(3).empty());
  for (const std::uint16_t voxel : {std::uint16_t{9}, std::uint16_t{2}, std::uint16_t{5}, std::uint16_t{2}}) {
    votes.record(3, {voxel, {.label = 7, .weight = 4}, {.label = 1, .weight = 3}});
  }
  ASSERT_EQ(votes.of(3).size(), 3U);
  EXPECT_EQ(votes.of(3)[0].voxel, 2);
  EXPECT_EQ(votes.of(3)[2].voxel, 9);
  votes.record(3, {5, {.label = 7, .weight = 4}, {.label = 7, .weight = 4}});
  EXPECT_EQ(votes.of(3).size(), 2U);
  EXPECT_TRUE(votes.of(2).empty());
  std::vector<bool> in_use(65536, true);
  votes.forget_unused(in_use);
  EXPECT_EQ(votes.of(3).size(), 2U);
  in_use[7] = false;
  votes.forget_unused(in_use);
  EXPECT_TRUE(votes.of(3).empty());
}

// A block whose voxel 5 frames voted for 7 with weight 4, and the regularizer wrote 1 into.
struct Overruled {
  VoxelMap map{MapOptions{}};
  FrameVotes votes;
  VoxelBlock& block = map.block(map.allocate({0, 0, 0}));

  Overruled() {
    block.set(5, {.weight = 10, .label_weight = 3, .vote_sum = 10, .label = 1});
    votes.record(0, {5, {.label = 7, .weight = 4}, {.label = 1, .weight = 3}});
  }
  VoxelLabel voted() const { return votes.voted(0, 5, {block.label(5), block.label_weight(5)}); }
  void rename(int from, int to) {
    SurfaceVoxels surface(map);
    map.begin_epoch();
    Renaming renaming;
    renaming.add(pid(from), pid(to));
    renaming.apply(map, votes, surface);
  }
};

TEST(FrameVotes, OfAnObjectThatBecomesAnotherAreForThatOne) {
  Overruled o;
  o.rename(7, 9);
  EXPECT_EQ(o.voted().label, 9);
  EXPECT_EQ(o.voted().weight, 4);
  EXPECT_EQ(o.block.label(5), 1) << "it stays overruled";
  EXPECT_EQ(o.map.changed_since(1), std::vector<Slot>{0}) << "there is something to regularize";
  o.rename(1, 2);
  EXPECT_EQ(o.block.label(5), 2);
  EXPECT_EQ(o.voted().label, 9) << "what the regularizer wrote is no vote of frames";
  EXPECT_EQ(o.voted().weight, 4);
}

TEST(FrameVotes, ThatSayWhatWasWrittenAreTheVoxelsOwn) {
  for (const bool written_becomes_voted : {true, false}) {
    Overruled o;
    written_becomes_voted ? o.rename(1, 7) : o.rename(7, 1);
    EXPECT_EQ(o.block.label(5), written_becomes_voted ? 7 : 1);
    EXPECT_EQ(o.block.label_weight(5), 4) << "as frames left it";
    EXPECT_TRUE(o.votes.of(0).empty());
  }
}

TEST(FrameVotes, OfFramesThatCameSinceAreCountedBeforeLabelsBecomeOthers) {
  Overruled o;
  o.block.set_label(5, 8);  // frames outweighed what was written, and voted for a third label
  o.block.set_label_weight(5, 2);
  o.rename(8, 1);  // which turns out to be what was written
  EXPECT_TRUE(o.votes.of(0).empty());
  EXPECT_EQ(o.block.label(5), 1);
  EXPECT_EQ(o.block.label_weight(5), 1) << "3 + 2 for it, 4 against";
}

TEST(FrameVotes, ADecisionTakesTheirPlaceAndTheirWeight) {
  Overruled o;
  o.votes.decide(0, 5, 3, o.block);
  EXPECT_EQ(o.block.label(5), 3);
  EXPECT_EQ(o.block.label_weight(5), 4);
  EXPECT_TRUE(o.votes.of(0).empty());
  o.votes.decide(0, 5, 6, o.block);
  EXPECT_EQ(o.block.label(5), 6);
  EXPECT_EQ(o.block.label_weight(5), 4);
}

TEST(FrameVotes, KeepWhatTheyAreForInUse) {
  Overruled o;
  std::vector<bool> in_use = ids_in_use(o.map);
  ASSERT_FALSE(in_use[7]);
  o.votes.add_in_use(in_use);
  EXPECT_TRUE(in_use[7]);
}

// A room in which the regularizer overrules some voxels of a chair that was taken for two.
struct Room {
  test::World world;
  LabelSlot left = world.seen(test::kChair, 30);
  LabelSlot right = world.seen(test::kChair);

  Room() {
    add_to(world, {test::table_top(test::stuff(test::kTable)), test::solid_box({-0.4, -0.2, 0.7}, {-0.1, 0.2, 0.9}, left),
                   test::solid_box({-0.1, -0.2, 0.7}, {0.1, 0.2, 0.9}, right)});
    std::mt19937 random(3);
    for (Slot slot = 0; slot < world.map.voxels.block_count(); ++slot) {
      test::BlockEdit block_edit(world.map.voxels.block(slot));
      BlockPlanes& block = *block_edit;
      for (std::size_t v = 0; v < kBlockVoxels; ++v) {
        block.weight[v] *= 10;
        block.vote_sum[v] *= 10;
        block.label_weight[v] *= 6;
        if (block.weight[v] <= 0 || random() % 8 != 0) continue;
        const std::uint16_t wrong[] = {number(left), number(right), number(test::stuff(test::kTable)), 0};
        block.label[v] = wrong[random() % 4];
        block.label_weight[v] = 1;
      }
    }
  }

  std::vector<std::uint16_t> labels() const {
    std::vector<std::uint16_t> all;
    for (Slot slot = 0; slot < world.map.voxels.block_count(); ++slot) {
      const BlockPlanes planes = test::planes_of(world.map.voxels.block(slot));
      all.insert(all.end(), planes.label.begin(), planes.label.end());
    }
    return all;
  }
};

// All of the map, so that it is divided in the same way whatever changed before.
std::size_t run_on_all(Regularizer& regularizer, VoxelMap& map) {
  map.begin_epoch();
  for (Slot slot = 0; slot < map.block_count(); ++slot) map.mark_changed(slot);
  return regularizer.run(map);
}

// Maintenance that looks at frames' votes alone decides the same whether the regularizer ran before; then what comes out is.
TEST(FrameVotes, HoweverOftenTheRegularizerRunsAroundAMergeTheLabelsAreTheSame) {
  std::vector<std::vector<std::uint16_t>> labels;
  for (const int runs : {0, 1, 3}) {
    Room room;
    Regularizer regularizer(RegularizerOptions{}, room.world.map.voxels);
    std::size_t overruled = 0;
    for (int i = 0; i < runs; ++i) overruled += run_on_all(regularizer, room.world.map.voxels);
    EXPECT_EQ(overruled > 100, runs > 0);
    SurfaceVoxels surface(room.world.map.voxels);
    room.world.map.voxels.begin_epoch();
    Renaming renaming;
    renaming.add(room.right, room.left);
    renaming.apply(room.world.map.voxels, regularizer.votes(), surface);
    for (int i = 0; i < std::max(runs, 1); ++i) run_on_all(regularizer, room.world.map.voxels);
    labels.push_back(room.labels());
  }
  EXPECT_EQ(labels[0], labels[1]);
  EXPECT_EQ(labels[0], labels[2]);
}

// Every voxel of one label is decided on, overruled or not.
TEST(FrameVotes, HoweverOftenTheRegularizerRunsAroundADecisionTheLabelsAreTheSame) {
  std::vector<std::vector<std::uint16_t>> labels;
  for (const int runs : {0, 1, 3}) {
    Room room;
    Regularizer regularizer(RegularizerOptions{}, room.world.map.voxels);
    for (int i = 0; i < runs; ++i) run_on_all(regularizer, room.world.map.voxels);
    SurfaceVoxels surface(room.world.map.voxels);
    room.world.map.voxels.begin_epoch();
    for (std::uint32_t i = 0; i < surface.size(); ++i) {
      if (place_m(surface[i], 0.024).x() > 0.3) surface.relabel(i, test::stuff(test::kWall));
    }
    surface.write_labels(room.world.map.voxels, regularizer.votes());
    for (int i = 0; i < std::max(runs, 1); ++i) run_on_all(regularizer, room.world.map.voxels);
    labels.push_back(room.labels());
  }
  EXPECT_EQ(labels[0], labels[1]);
  EXPECT_EQ(labels[0], labels[2]);
}

// Records the vote of every tenth voxel of the surface as overruled by what the map holds.
void overrule(test::World& world, LabelSlot voted) {
  const SurfaceVoxels surface(world.map.voxels);
  for (std::uint32_t i = 0; i < surface.size(); i += 10) {
    const auto [slot, voxel] = surface.place_of(i);
    Voxel held = world.map.voxels.block(slot).at(voxel);
    held.vote_sum = 5;
    world.map.voxels.block(slot).set(voxel, held);
    if (surface.label(i) == voted) continue;
    world.votes.record(slot, {voxel, {number(voted), 5}, {held.label, held.label_weight}});
  }
}

TEST(FrameVotes, MaintenanceMergesThemWithTheirObjects) {
  test::World world;
  const LabelSlot larger = world.seen(test::kChair, 30);
  const LabelSlot smaller = world.seen(test::kChair);
  add_to(world, {test::solid_box({-0.4, -0.2, 0.1}, {0.2, 0.2, 0.5}, larger),
                 test::solid_box({0.2, -0.2, 0.1}, {0.4, 0.2, 0.5}, smaller)});
  overrule(world, smaller);
  world.run();
  ASSERT_EQ(world.map.objects.find(smaller), nullptr) << "merged";
  for (Slot slot = 0; slot < world.map.voxels.block_count(); ++slot) {
    for (const OverruledVote& vote : world.votes.of(slot)) {
      EXPECT_NE(vote.voted.label, number(smaller));
      EXPECT_NE(vote.written.label, number(smaller));
      EXPECT_NE(vote.voted.label, vote.written.label);
    }
  }
}

// Things on the table are carved, and the level surface near the floor becomes floor.
TEST(FrameVotes, WhatIsCarvedOrLevelledIsNoLongerOverruled) {
  test::World world;
  const LabelSlot chair = world.seen(test::kChair);
  add_to(world, {test::solid_ground(test::kUp, -0.1, test::stuff(test::kFloor)),
                 test::solid_box({-1.2, -0.9, -0.12}, {-0.9, 0.9, -0.1}, chair), test::table_top(test::stuff(test::kTable)),
                 test::box_on_table(test::stuff(test::kTable))});
  overrule(world, chair);
  const auto labels_before = [&] {
    std::vector<std::array<std::uint16_t, kBlockVoxels>> labels;
    for (Slot slot = 0; slot < world.map.voxels.block_count(); ++slot)
      labels.push_back(test::planes_of(world.map.voxels.block(slot)).label);
    return labels;
  }();
  FrameVotes before = world.votes;
  world.finish();
  std::size_t decided = 0;
  for (Slot slot = 0; slot < world.map.voxels.block_count(); ++slot) {
    const BlockPlanes block = test::planes_of(world.map.voxels.block(slot));
    for (const OverruledVote& vote : before.of(slot)) {
      if (block.label[vote.voxel] == labels_before[slot][vote.voxel]) continue;
      ++decided;
      EXPECT_EQ(block.label_weight[vote.voxel], 5) << "the weight of the frames";
      EXPECT_EQ(world.votes.voted(slot, vote.voxel, {block.label[vote.voxel], 5}).label, block.label[vote.voxel]);
    }
  }
  EXPECT_GT(decided, 10U);
}

}  // namespace
}  // namespace panoptic
