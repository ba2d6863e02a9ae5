// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_maintenance.h"

#include <gtest/gtest.h>

#include <vector>

#include "panoptic/parallel.h"
#include "tests/block_planes.h"
#include "tests/objects/maintained_world.h"

namespace panoptic {
namespace {

using test::add_to;
using test::box_on_table;
using test::kBag;
using test::kChair;
using test::kFirst;
using test::kFloor;
using test::kTable;
using test::kUp;
using test::maybe_a_sofa;
using test::pid;
using test::solid_box;
using test::solid_ground;
using test::stuff;
using test::table_top;
using test::World;

// All rules have something to do here.
World busy_world(const MaintenanceOptions& options = {}) {
  World world(options);
  const LabelSlot chair = world.seen(kChair);
  const LabelSlot half = world.seen(kChair);
  const LabelSlot bag = world.seen(kBag, 20, maybe_a_sofa(0.3F));
  const LabelSlot rare = world.seen(kChair, 2);
  add_to(world, {solid_ground(kUp, -0.1, stuff(kFloor)), table_top(stuff(kTable)), box_on_table(stuff(kTable)),
                 solid_box({-1.1, -0.8, -0.2}, {-0.9, -0.6, 0.4}, chair), solid_box({-0.9, -0.8, -0.2}, {-0.8, -0.6, 0.4}, half),
                 solid_box({-1.1, 0.6, -0.2}, {0.9, 0.8, 0.3}, bag), solid_box({0.9, -0.6, -0.2}, {1, -0.5, 0}, rare),
                 solid_box({0.3, -0.9, -0.2}, {0.7, -0.5, 0.3}, LabelSlot::kUnknown)});
  return world;
}

TEST(ObjectMaintenance, ChangesNothingWhenDisabled) {
  World world = busy_world(MaintenanceOptions{.enabled = false});
  const std::uint64_t hash = world.map.voxels.hash();
  const std::uint64_t epoch = world.map.voxels.epoch();
  const std::size_t objects = world.map.objects.count();
  world.maintenance.saw_together(std::vector{PanopticId{10}, PanopticId{11}});
  world.run();
  world.finish();
  EXPECT_EQ(world.map.voxels.hash(), hash);
  EXPECT_EQ(world.map.voxels.epoch(), epoch);
  EXPECT_EQ(world.map.objects.count(), objects);
}

TEST(ObjectMaintenance, IsTheSameAtAnyThreadCount) {
  std::vector<std::uint64_t> hashes;
  std::vector<std::size_t> counts;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    World world = busy_world();
    const std::uint64_t before = world.map.voxels.hash();
    world.run();
    world.finish();
    hashes.push_back(world.map.voxels.hash());
    counts.push_back(world.map.objects.count());
    EXPECT_NE(hashes.back(), before);
  }
  set_thread_count(0);
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(counts[0], counts[1]);
}

TEST(ObjectMaintenance, LooksAtWhatChangedAlone) {
  World world = busy_world();
  const std::uint64_t before = world.map.voxels.hash();
  world.maintenance.restore({{}, world.map.voxels.epoch()});
  world.run();
  EXPECT_EQ(world.map.voxels.hash(), before) << "nothing changed since";
  world.maintenance.restore({});
  world.run();
  EXPECT_NE(world.map.voxels.hash(), before);
}

// A row of tables and chairs grows; each step has a chair that touches the one of the step before.
TEST(ObjectMaintenance, WhatChangedIsEnoughToLookAt) {
  World looks_at_changes;
  World looks_at_all;
  for (int step = 0; step < 8; ++step) {
    for (World* world : {&looks_at_changes, &looks_at_all}) {
      const Vec3d at(0.8 * step, 0, 0);
      const LabelSlot chair = world->seen(kChair);
      const LabelSlot half = world->seen(kChair);
      const std::vector<test::Solid> solids = {solid_ground(kUp, -0.1, stuff(kFloor)),
                                               solid_box(at + Vec3d(0, 0, 0.55), at + Vec3d(0.8, 0.4, 0.7), stuff(kTable)),
                                               solid_box(at + Vec3d(0.3, 0.1, 0.6), at + Vec3d(0.5, 0.3, 0.9), stuff(kTable)),
                                               solid_box(at + Vec3d(0, -0.8, -0.2), at + Vec3d(0.7, -0.6, 0.4), chair),
                                               solid_box(at + Vec3d(0.7, -0.8, -0.2), at + Vec3d(0.8, -0.6, 0.4), half)};
      test::add_solids(world->map.voxels, solids, at + Vec3d(-0.1, -0.9, -0.2), at + Vec3d(0.9, 0.6, 1.2));
      if (world == &looks_at_all) world->maintenance.restore({world->maintenance.state().covisible, 0});
      world->run();
    }
    EXPECT_EQ(looks_at_changes.map.voxels.hash(), looks_at_all.map.voxels.hash()) << "step " << step;
  }
  EXPECT_LE(looks_at_changes.ids().size(), 8U + 8U) << "halves were merged, and what stands on the tables was carved";
}

TEST(ObjectMaintenance, TouchesLabelsAloneAndMarksEveryBlockThatItChanges) {
  World world = busy_world();
  const World before = busy_world();
  const std::uint64_t epoch = world.map.voxels.epoch();
  world.run();
  world.finish();
  std::size_t changed = 0;
  for (Slot slot = 0; slot < world.map.voxels.block_count(); ++slot) {
    const BlockPlanes now = test::planes_of(world.map.voxels.block(slot));
    const BlockPlanes then = test::planes_of(before.map.voxels.block(slot));
    EXPECT_EQ(now.distance, then.distance);
    EXPECT_EQ(now.weight, then.weight);
    EXPECT_EQ(now.label_weight, then.label_weight);
    if (now.label == then.label) continue;
    ++changed;
    EXPECT_GT(world.map.voxels.changed_at(slot), epoch);
  }
  EXPECT_GT(changed, 10U);
}

TEST(ObjectMaintenance, LeavesNoVoxelWithAnIdThatIsNoObject) {
  World world = busy_world();
  for (int round = 0; round < 3; ++round) {
    if (round < 2) world.run();
    if (round == 2) world.finish();
    const std::vector<bool> in_use = ids_in_use(world.map.voxels);
    for (int id = kFirst; id < number(LabelSlot::kNoVote); ++id) {
      const bool is_object = world.map.objects.find(pid(id)) != nullptr;
      EXPECT_TRUE(is_object || !in_use[static_cast<std::size_t>(id)]) << id;
    }
    EXPECT_FALSE(in_use[65535]);
  }
}

TEST(ObjectMaintenance, GetsAlongWithAnEmptyMapAndWithAMapWithoutLabels) {
  World empty;
  empty.run();
  empty.finish(0);
  EXPECT_EQ(empty.map.voxels.block_count(), 0U);
  World unlabelled;
  add_to(unlabelled, {solid_ground(kUp, 0, LabelSlot::kUnknown)});
  unlabelled.run();
  EXPECT_TRUE(unlabelled.ids().empty());
  unlabelled.finish();
  EXPECT_EQ(unlabelled.ids().size(), 1U) << "one large region that frames called unknown";
}

TEST(ObjectMaintenance, GetsAlongWithThousandsOfObjects) {
  World world;
  constexpr int kSide = 50;
  std::vector<LabelSlot> ids;
  for (int n = 0; n < kSide * kSide; ++n) ids.push_back(world.seen(n % 2 == 0 ? kChair : kBag, 6));
  for (std::int32_t b = 0; b < 13; ++b) {  // tiles of 4 voxels
    for (std::int32_t c = 0; c < 13; ++c) {
      test::BlockEdit block_edit(world.map.voxels.block(world.map.voxels.allocate({b, c, 0})));
      BlockPlanes& block = *block_edit;
      for (int v = 0; v < kBlockVoxels; ++v) {
        const int x = (b * kBlockSide + v % kBlockSide) / 4;
        const int y = (c * kBlockSide + v / kBlockSide % kBlockSide) / 4;
        const int z = v / (kBlockSide * kBlockSide);
        if (x >= kSide || y >= kSide || z > 12) continue;
        const auto i = static_cast<std::size_t>(v);
        block.distance[i] = static_cast<float>(z - 6) * world.map.voxels.voxel_size_m();
        block.weight[i] = 1;
        block.label[i] = number(ids[static_cast<std::size_t>(x + kSide * y)]);
      }
    }
  }
  ASSERT_EQ(world.ids().size(), ids.size());
  world.run();
  for (const LabelSlot id : ids) ASSERT_NE(world.map.objects.find(world.map.objects.survivor(id)), nullptr);
  for (const LabelSlot id : world.ids()) ASSERT_NE(world.map.objects.find(id), nullptr);
  EXPECT_LT(world.ids().size(), ids.size()) << "diagonal neighbours of a class lie against each other";
  world.finish();
  for (const LabelSlot id : world.ids()) ASSERT_NE(world.map.objects.find(id), nullptr);
}

// Without a fresh id the thing stays with the table: no label is lost.
TEST(ObjectMaintenance, CarvesNothingWhenAllIdsAreTaken) {
  World world;
  add_to(world, {table_top(stuff(kTable)), box_on_table(stuff(kTable)),
                 solid_box({-1.1, -0.8, 0}, {-0.8, -0.5, 0.3}, LabelSlot::kUnknown)});
  while (world.map.objects.create()) {
  }
  const std::uint64_t hash = world.map.voxels.hash();
  world.run();
  world.finish();
  EXPECT_EQ(world.map.voxels.hash(), hash);
}

}  // namespace
}  // namespace panoptic
