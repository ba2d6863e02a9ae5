// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Sessions in which every slot was given once: what still names the slot of an object that is no more keeps it from others.
#include <gtest/gtest.h>

#include "panoptic/mapper.h"
#include "panoptic/mapping/mapper_parts.h"
#include "tests/mapping/ball_on_floor.h"

namespace panoptic {
namespace {

constexpr std::uint16_t kFloor = 2;
constexpr std::uint16_t kFirst = 4;  // of test_labels
constexpr PanopticId kFirstAnew{65535};
constexpr std::uint16_t kVoxel = 77;

Frame ball_frame() {
  return test::render(test::ball_on_floor(), test::small_camera(), test::look_at({2, -0.9, 0}, {0, 0, 0}), 0);
}

// One block far from the ball, of floor, but for some voxels of slot 6.
VoxelMap far_map() {
  VoxelMap map{MapOptions{}};
  VoxelBlock& block = map.block(map.allocate({100, 100, 100}));
  for (int v = 0; v < kBlockVoxels; ++v) {
    const std::uint16_t label = v < 64 ? kFirst + 2 : kFloor;
    block.set(v, {.weight = 1, .label_weight = 0.5F, .label = label});
  }
  return map;
}

// 4 and 6 are objects, 5 was merged into 6 and something may name it still; all other slots were given and are free.
ObjectRegistry long_lived() {
  ObjectRegistry objects(kFirst);
  while (objects.create()) continue;
  objects.merge(LabelSlot{kFirst + 1}, LabelSlot{kFirst + 2}, 0);
  std::vector<bool> in_use(kLabelSlots, false);
  for (std::uint16_t slot = kFirst; slot < kFirst + 3; ++slot) in_use[slot] = true;
  objects.retire_unused(in_use);
  RegistryState state = objects.state();
  state.created_since_retirement = 1'000'000;
  return {kFirst, std::move(state)};
}

struct LongSession {
  Mapper mapper{{}, test::test_labels()};

  explicit LongSession(RegularizerState regularizer = {}) {
    MapperState state;
    state.regularizer = std::move(regularizer);
    mapper.parts().restore({test::test_labels(), far_map(), long_lived()}, std::move(state));
  }
  // The slot of the ball, which is new to the map.
  LabelSlot add_ball() {
    const Frame frame = ball_frame();
    EXPECT_EQ(mapper.add(frame, test::segmented(frame)), Outcome{});
    const Object* ball = mapper.map().objects.find(kFirstAnew);
    return ball == nullptr ? LabelSlot::kNoVote : ball->slot;
  }
};

CoreVoxel floor_voxel() {
  CoreVoxel voxel{};
  voxel.voxel = kVoxel;
  voxel.held = voxel.voted = {kFloor, 0.5F};
  voxel.weight = 1;
  return voxel;
}

TEST(Slots, AreGivenAnewWhenNothingNamesThem) {
  LongSession run;
  EXPECT_EQ(run.add_ball(), LabelSlot{kFirst});
  EXPECT_EQ(run.mapper.map().objects.find(PanopticId{kFirst}), nullptr) << "no voxel held it";
  EXPECT_EQ(run.mapper.segment_ids().front(), kFirstAnew);
}

TEST(Slots, OfAnObjectThatOnlyAnOverruledVoteNamesAreKept) {
  for (const bool voted : {true, false}) {
    const VoxelLabel floor{kFloor, 0.5F};
    const VoxelLabel gone{kFirst, 0.5F};
    const OverruledVote vote{kVoxel, voted ? gone : floor, voted ? floor : gone};
    LongSession run({{{vote}}, {}});
    EXPECT_EQ(run.add_ball(), LabelSlot{kFirst + 1}) << "the first one that nothing names";
    EXPECT_EQ(run.mapper.map().objects.named_by(LabelSlot{kFirst}), PanopticId{kFirst});
    EXPECT_EQ(run.mapper.map().objects.find(LabelSlot{kFirst}) != nullptr, voted) << "what frames voted for may come back";
    run.mapper.finish();
    EXPECT_EQ(run.mapper.map().objects.find(LabelSlot{kFirst}), nullptr) << "no voxel holds it at the end";
  }
}

TEST(Slots, OfATileThatIsBeingSolvedNeverComeToMeanAnotherObject) {
  LongSession run;
  TileChanges changes = run.mapper.parts().solve(run.mapper.parts().gather({0}));
  EXPECT_EQ(changes.next_id, kFirstAnew);
  changes.changes = {{floor_voxel(), {kFirst, 0.5F}}};
  ASSERT_EQ(run.add_ball(), LabelSlot{kFirst}) << "the slot is another object's by now";
  run.mapper.parts().write_back(changes);
  EXPECT_EQ(run.mapper.map().voxels.block(0).label(kVoxel), kFloor);

  changes.changes[0].label = {kFirst + 2, 0.5F};
  changes.changes[0].before.voted = {kFirst, 0.5F};
  run.mapper.parts().write_back(changes);
  EXPECT_EQ(run.mapper.map().voxels.block(0).label(kVoxel), kFloor) << "what was voted for is another object by now";

  changes.changes[0].before.voted = {kFloor, 0.5F};
  run.mapper.parts().write_back(changes);
  EXPECT_EQ(run.mapper.map().voxels.block(0).label(kVoxel), kFirst + 2) << "this one is still the same";
}

TEST(Slots, OfATileThatIsBeingSolvedFollowWhatWasMergedMeanwhile) {
  LongSession run;
  TileChanges changes = run.mapper.parts().solve(run.mapper.parts().gather({0}));
  changes.changes = {{floor_voxel(), {kFirst + 1, 0.5F}}};
  changes.changes[0].before.voted = {kFirst + 1, 0.5F};
  run.mapper.parts().write_back(changes);
  EXPECT_EQ(run.mapper.map().voxels.block(0).label(kVoxel), kFirst + 2);
  for (const auto& of_block : run.mapper.parts().state().regularizer.votes)
    EXPECT_TRUE(of_block.empty()) << "it is what was voted for";
}

}  // namespace
}  // namespace panoptic
