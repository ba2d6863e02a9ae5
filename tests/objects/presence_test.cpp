// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/presence.h"

#include <gtest/gtest.h>

#include <vector>

#include "panoptic/frame_statistics.h"
#include "panoptic/map/space_cells.h"
#include "tests/objects/maintained_world.h"

namespace panoptic {
namespace {

using test::kChair;
using test::kSofa;
using test::solid_box;
using test::World;

constexpr ObjectPresence::Rules kRules{6};

// A camera that takes so many frames a second.
ObjectPresence::TimeOf camera_of(double per_second) {
  return [=](std::int64_t frame) { return static_cast<double>(frame) / per_second; };
}
const ObjectPresence::TimeOf kFrames = camera_of(30);

struct Room : World {
  ObjectPresence presence;

  // An object that was seen in 20 frames from this one on.
  LabelSlot seen_from(std::int64_t frame, ClassId class_id) {
    const LabelSlot slot = *map.objects.create();
    for (int i = 0; i < 20; ++i) map.objects.observe(slot, {class_id, 0.9F, {}}, frame + i);
    return slot;
  }

  // Looks through the voxels of an object on this side of x.
  void look_through(LabelSlot label, double up_to_x_m, std::int64_t frame = 50) {
    for (Slot slot = 0; slot < map.voxels.block_count(); ++slot) {
      const VoxelIndex first = first_voxel(map.voxels.index_of(slot));
      for (int b = 0; b < kBlockBricks; ++b) {
        std::uint64_t voxels = 0;
        const Brick& brick = map.voxels.block(slot).brick(b);
        for (int v = 0; v < kBrickVoxels; ++v) {
          const VoxelIndex at = voxel_at(first, offset_in_block(b, v));
          const bool is_own = (brick.stored() >> v & 1) != 0 && brick.label(v) == number(label);
          if (is_own && center_m(at, map.voxels.voxel_size_m()).x() < up_to_x_m) voxels |= std::uint64_t{1} << v;
        }
        if (voxels == 0) continue;
        presence.looks_through(slot, b, voxels, frame, map);
        map.voxels.block(slot).forget(b, voxels);
      }
    }
  }
};

TEST(ObjectPresence, AnObjectIsGoneWhenMoreThanHalfOfItWasLookedThrough) {
  Room room;
  const LabelSlot chair = room.seen(kChair);
  const PanopticId id = room.map.objects.id_of(chair);
  add_to(room, {solid_box({-0.5, -0.3, 0}, {0.5, 0.3, 0.4}, chair)});
  room.look_through(chair, -0.2);
  room.presence.find_gone(kRules, room.votes, room.map);
  EXPECT_TRUE(room.map.history.past.empty()) << "a third of it";
  EXPECT_GT(room.count(chair), 0U);
  room.look_through(chair, 0.2);
  room.presence.find_gone(kRules, room.votes, room.map);
  ASSERT_EQ(room.map.history.past.size(), 1U);
  const PastObject& past = room.map.history.past[0];
  EXPECT_EQ(past.id, id);
  EXPECT_EQ(past.class_id, kChair);
  EXPECT_EQ(past.gone_frame, 50);
  EXPECT_EQ(past.observations, 20U);
  EXPECT_NEAR(past.box.min_m.x(), -0.5, 0.06);
  EXPECT_NEAR(past.box.max_m.x(), 0.5, 0.06);
  EXPECT_EQ(room.count(chair), 0U) << "what was left of it is cleared";
}

TEST(ObjectPresence, WhatIsGoneHasNoVotesLeftThatCouldBringItBack) {
  Room room;
  const LabelSlot chair = room.seen(kChair);
  add_to(room, {solid_box({-0.5, -0.3, 0}, {0.5, 0.3, 0.4}, chair)});
  room.look_through(chair, 0.3);
  room.votes.record(0, {.voxel = 7, .voted = {number(chair), 2}, .written = {1, 2}});
  room.presence.find_gone(kRules, room.votes, room.map);
  ASSERT_EQ(room.map.history.past.size(), 1U);
  EXPECT_TRUE(room.votes.of(0).empty());
}

TEST(ObjectPresence, WhatANetworkSeesSinceIsNotGone) {
  Room room;
  const LabelSlot chair = room.seen(kChair);
  add_to(room, {solid_box({-0.5, -0.3, 0}, {0.5, 0.3, 0.4}, chair)});
  room.look_through(chair, 0.3);
  room.map.objects.observe(chair, {kChair, 0.9F, {}}, 60);
  room.presence.find_gone(kRules, room.votes, room.map);
  EXPECT_TRUE(room.map.history.past.empty());
  EXPECT_GT(room.count(chair), 0U);
}

TEST(ObjectPresence, WhatHasASurfaceAgainIsNotGone) {
  Room room;
  const LabelSlot chair = room.seen(kChair);
  const std::vector<test::Solid> solids = {solid_box({-0.5, -0.3, 0}, {0.5, 0.3, 0.4}, chair)};
  add_to(room, solids);
  room.look_through(chair, 1);
  EXPECT_EQ(room.count(chair), 0U);
  add_to(room, solids);
  room.presence.find_gone(kRules, room.votes, room.map);
  EXPECT_TRUE(room.map.history.past.empty());
}

TEST(ObjectPresence, WhatWasHardlyEverSeenWasNeverThere) {
  Room room;
  const LabelSlot chair = room.seen(kChair, 3);
  add_to(room, {solid_box({-0.5, -0.3, 0}, {0.5, 0.3, 0.4}, chair)});
  room.look_through(chair, 1);
  room.presence.find_gone(kRules, room.votes, room.map);
  EXPECT_TRUE(room.map.history.past.empty());
}

// A network called three corners of a sideboard a chair, which nobody took away.
TEST(ObjectPresence, CrumbsThatLieFarApartWereNoThing) {
  for (const bool is_whole : {false, true}) {
    Room room;
    const LabelSlot chair = room.seen(kChair);
    std::vector<test::Solid> solids = {solid_box({-0.5, -0.3, 0}, {0.5, 0.3, 0.8}, chair)};
    if (!is_whole) {
      solids = {solid_box({-0.5, -0.3, 0}, {-0.45, -0.25, 0.05}, chair), solid_box({-0.05, 0.2, 0.4}, {0, 0.25, 0.45}, chair),
                solid_box({0.45, 0.25, 0.75}, {0.5, 0.3, 0.8}, chair)};
    }
    add_to(room, solids);
    room.look_through(chair, 1);
    room.presence.find_gone(kRules, room.votes, room.map);
    EXPECT_EQ(room.map.history.past.size(), is_whole ? 1U : 0U);
  }
}

// A mask reached over to what stands beside the chair.
TEST(ObjectPresence, WhatIsGoneWasWhereTheViewsLookThrough) {
  Room room;
  const LabelSlot chair = room.seen(kChair);
  add_to(room, {solid_box({-0.3, -0.3, 0}, {0.3, 0.3, 0.8}, chair), solid_box({0.9, -0.2, 0}, {1.1, 0.2, 0.4}, chair)});
  room.look_through(chair, 0.5);
  room.presence.find_gone(kRules, room.votes, room.map);
  ASSERT_EQ(room.map.history.past.size(), 1U);
  EXPECT_NEAR(room.map.history.past[0].box.max_m.x(), 0.3, 0.06);
  EXPECT_NEAR(room.map.history.past[0].box.min_m.x(), -0.3, 0.06);
}

// Every cell around a box was free once.
void come_up(Room& room, const Vec3d& low_m, const Vec3d& high_m, std::int64_t frame = 70) {
  const double cell_m = 4 * double{room.map.voxels.voxel_size_m()};
  std::vector<CellIndex> cells;
  for (double x = low_m.x() - cell_m; x < high_m.x() + cell_m; x += cell_m) {
    for (double y = low_m.y() - cell_m; y < high_m.y() + cell_m; y += cell_m) {
      for (double z = low_m.z() - cell_m; z < high_m.z() + cell_m; z += cell_m) {
        cells.push_back(*room.map.free_space.cell_around({x, y, z}));
      }
    }
  }
  room.presence.came_up(cells, frame);
}

// The frames before frame `n` of a camera that takes so many a second.
ObjectPresence::FramesBefore before(std::uint64_t n, double per_second = 30) {
  FrameStatistics frames;
  for (std::uint64_t i = 0; i < n; ++i) frames.count_used({static_cast<double>(i) / per_second});
  const double now_s = static_cast<double>(n) / per_second;
  return {n, frames.used_until(now_s - ObjectPresence::kStay_s), frames.used_until(now_s - ObjectPresence::kLongestGap_s)};
}

TEST(ObjectPresence, WhatStaysInACellForTwoSecondsHasSettled) {
  ObjectPresence presence;
  const std::vector<CellIndex> stays = {{1, 2, 3}};
  const std::vector<CellIndex> both = {{1, 2, 3}, {4, 5, 6}};
  for (std::uint64_t n = 100; n < 160; ++n) {
    EXPECT_TRUE(presence.settled(n % 25 == 0 ? both : stays, before(n)).empty()) << "the other one comes back too seldom";
  }
  EXPECT_EQ(presence.settled(both, before(160)), stays);
  EXPECT_EQ(presence.settled(both, before(165)), stays) << "a short gap";
  EXPECT_TRUE(presence.settled(stays, before(180)).empty()) << "it had left";
  EXPECT_TRUE(presence.settled({}, before(300)).empty());
  EXPECT_TRUE(presence.state().stays.empty());
}

// Two seconds are two seconds, whatever the camera gives, and however many frames were dropped.
TEST(ObjectPresence, HowLongSomethingStaysIsAMatterOfTimeAndNotOfFrames) {
  const std::vector<CellIndex> cells = {{1, 2, 3}};
  for (const auto& [per_second, settles_after] :
       {std::pair(90.0, 180U), std::pair(30.0, 60U), std::pair(5.0, 10U), std::pair(1.0, 5U)}) {
    ObjectPresence presence;
    std::uint64_t n = 100;
    while (n < 400 && presence.settled(cells, before(n, per_second)).empty()) ++n;
    EXPECT_EQ(n, 100 + settles_after) << per_second << " frames a second";
  }
}

TEST(ObjectPresence, WhatIsGoneAndComesElsewhereWasMovedIfItIsOfOneClassAndSize) {
  for (const auto& [class_id, height_m, moved] :
       {std::tuple(kChair, 0.4, true), std::tuple(kSofa, 0.4, false), std::tuple(kChair, 1.1, false)}) {
    Room room;
    const LabelSlot before = room.seen(kChair);
    const LabelSlot after = room.seen_from(60, class_id);
    const LabelSlot other = room.seen(kChair);
    const PanopticId id = room.map.objects.id_of(before);
    const Vec3d low(0.4, -0.2, 0);
    const Vec3d high(0.8, 0.2, height_m);
    add_to(room, {solid_box({-0.9, -0.2, 0}, {-0.5, 0.2, 0.4}, before), solid_box(low, high, after),
                  solid_box({-0.2, 0.5, 0}, {0.2, 0.8, 0.4}, other)});
    room.look_through(before, 1);
    come_up(room, low, high);
    room.presence.find_gone(kRules, room.votes, room.map);
    room.presence.find_arrivals(kFrames, room.map);
    ASSERT_EQ(room.map.history.past.size(), 1U);
    ASSERT_EQ(room.map.history.arrivals.size(), 1U) << "the other one was always there";
    const auto& [came, arrival] = *room.map.history.arrivals.begin();
    EXPECT_EQ(came, room.map.objects.id_of(after));
    EXPECT_EQ(arrival.moved_from, moved ? id : PanopticId::kUnknown);
    EXPECT_EQ(room.map.history.past[0].moved_to, moved ? came : PanopticId::kUnknown);
    if (moved) {
      EXPECT_GT(arrival.confidence, 0.6);
    }
  }
}

// Beside a wall little of a thing is in cells that were known to be free.
TEST(ObjectPresence, APartInFreeSpaceIsEnoughIfItCameUpWhenTheThingWasFirstSeen) {
  for (const auto& [came_at, per_second, half_m, appeared] :
       {std::tuple(70, 30, 0.1, true), std::tuple(170, 30, 0.1, false), std::tuple(170, 30, 0.5, true),
        std::tuple(170, 60, 0.1, true), std::tuple(80, 5, 0.1, false)}) {
    Room room;
    const LabelSlot chair = room.seen_from(60, kChair);
    add_to(room, {solid_box({-0.5, -0.3, 0}, {0.5, 0.3, 0.8}, chair)});
    come_up(room, {-half_m, -0.3, 0}, {half_m, 0.3, 0.8}, came_at);
    room.presence.find_arrivals(camera_of(per_second), room.map);
    EXPECT_EQ(room.map.history.arrivals.size(), appeared ? 1U : 0U) << came_at << " " << per_second << " " << half_m;
  }
}

TEST(ObjectPresence, WhatNoNetworkSawDidNotCome) {
  Room room;
  const LabelSlot region = *room.map.objects.create();
  add_to(room, {solid_box({-0.5, -0.3, 0}, {0.5, 0.3, 0.8}, region)});
  come_up(room, {-0.5, -0.3, 0}, {0.5, 0.3, 0.8});
  room.presence.find_arrivals(kFrames, room.map);
  EXPECT_TRUE(room.map.history.arrivals.empty());
}

// Three crumbs that a mask left on another thing, of which one is at its rim.
TEST(ObjectPresence, ACrumbInFreeSpaceDidNotCome) {
  Room room;
  const LabelSlot chair = room.seen_from(60, kChair);
  add_to(room, {solid_box({-0.5, 0, 0.4}, {-0.48, 0.02, 0.42}, chair), solid_box({0, 0, 0.4}, {0.02, 0.02, 0.42}, chair),
                solid_box({0.5, 0, 0.4}, {0.52, 0.02, 0.42}, chair)});
  ASSERT_GT(room.count(chair), 0U);
  come_up(room, {0.5, 0, 0.4}, {0.52, 0.02, 0.42});
  room.presence.find_arrivals(kFrames, room.map);
  EXPECT_TRUE(room.map.history.arrivals.empty());
}

// The first of two things of one size is gone, and the second came.
void one_goes_and_one_comes(Room& room, LabelSlot first, LabelSlot second) {
  const Vec3d low(0.4, -0.2, 0);
  const Vec3d high(0.8, 0.2, 0.4);
  add_to(room, {solid_box({-0.9, -0.2, 0}, {-0.5, 0.2, 0.4}, first), solid_box(low, high, second)});
  room.look_through(first, 0);
  come_up(room, low, high);
  room.presence.find_gone(kRules, room.votes, room.map);
  room.presence.find_arrivals(kFrames, room.map);
}

// A chair goes in frame 50, and another one of its size came when the first was still there, or after that.
TEST(ObjectPresence, WhatCameWhileTheOtherWasStillSeenIsAnotherOne) {
  for (const bool is_late : {false, true}) {
    Room room;
    const LabelSlot before = room.seen(kChair);  // in frames 0 to 19
    const LabelSlot after = room.seen_from(is_late ? 20 : 19, kChair);
    one_goes_and_one_comes(room, before, after);
    ASSERT_EQ(room.map.history.past.size(), 1U);
    EXPECT_EQ(room.map.history.past[0].moved_to != PanopticId::kUnknown, is_late);
  }
}

TEST(ObjectPresence, AMoveThatWasToldStaysWhenTheThingGoesAgain) {
  Room room;
  const LabelSlot first = room.seen(kChair);
  const LabelSlot second = room.seen_from(60, kChair);
  const PanopticId second_id = room.map.objects.id_of(second);
  one_goes_and_one_comes(room, first, second);
  ASSERT_EQ(room.map.history.past[0].moved_to, second_id);
  room.look_through(second, 1, 90);
  room.presence.find_gone(kRules, room.votes, room.map);
  room.map.prune();
  room.presence.find_arrivals(kFrames, room.map);
  ASSERT_EQ(room.map.history.past.size(), 2U);
  EXPECT_EQ(room.map.history.past[0].moved_to, second_id);
  EXPECT_TRUE(room.map.history.arrivals.empty());
}

}  // namespace
}  // namespace panoptic
