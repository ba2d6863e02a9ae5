// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_maintenance.h"

#include <gtest/gtest.h>

#include <iterator>
#include <set>
#include <vector>

#include "tests/block_planes.h"
#include "tests/objects/maintained_world.h"

namespace panoptic {
namespace {

using test::add_to;
using test::kBag;
using test::kChair;
using test::kFloor;
using test::kSofa;
using test::kUp;
using test::maybe_a_sofa;
using test::solid_box;
using test::solid_ground;
using test::stuff;
using test::World;

LabelSlot add_long_thing(World& world, double length_m, const std::vector<ClassProbability>& probabilities) {
  const LabelSlot id = world.seen(kBag, 20, probabilities);
  add_to(world, {solid_box({-1, 0, 0}, {-1 + length_m, 0.4, 0.4}, id)});
  return id;
}

TEST(ObjectMaintenance, ALongBagThatMayBeASofaBecomesASofa) {
  World world;
  const LabelSlot id = add_long_thing(world, 1.8, maybe_a_sofa(0.2F));
  EXPECT_EQ(world.map.objects.class_of(id), kBag);
  world.run();
  EXPECT_EQ(world.map.objects.class_of(id), kBag) << "while it grows nothing is ruled out";
  world.finish();
  EXPECT_EQ(world.map.objects.class_of(id), kSofa);
  EXPECT_EQ(world.ids(), std::set{id});
}

TEST(ObjectMaintenance, AShortBagThatMayBeASofaStaysABag) {
  World world;
  const LabelSlot id = add_long_thing(world, 0.6, maybe_a_sofa(0.4F));
  world.finish();
  EXPECT_EQ(world.map.objects.class_of(id), kBag);
}

// 1.1 m is too long for a bag, but no other class is known, and the outline may be wrong.
TEST(ObjectMaintenance, ABagSomewhatTooLongThatCanBeNothingElseStaysABag) {
  World world;
  const LabelSlot id = add_long_thing(world, 1.1, {{kBag, 1}});
  world.finish();
  EXPECT_EQ(world.map.objects.class_of(id), kBag);
  EXPECT_EQ(world.ids(), std::set{id});
}

TEST(ObjectMaintenance, AnAbsurdlyLongBagThatCanBeNothingElseIsNoObject) {
  World world;
  const LabelSlot id = add_long_thing(world, 2.0, {{kBag, 1}});
  world.finish();
  EXPECT_FALSE(world.ids().contains(id));
}

TEST(ObjectMaintenance, DropsStrayPiecesAndFillsThemFromAroundThem) {
  World world;
  const LabelSlot chair = world.seen(kChair);
  add_to(world, {solid_ground(kUp, 0, stuff(kFloor)), solid_box({-0.8, -0.4, -0.1}, {-0.4, 0, 0.4}, chair)});
  SurfaceVoxels surface(world.map.voxels);
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    const Vec3d p = place_m(surface[i], world.map.voxels.voxel_size_m());
    if ((p - Vec3d(0.5, 0.3, 0)).norm() < 0.1) surface.relabel(i, chair);
  }
  surface.write_labels(world.map.voxels, world.votes);
  ASSERT_EQ(world.at({0.5, 0.3, 0}), chair);
  World unlevelled(MaintenanceOptions{.floor_height_m = 0});
  unlevelled.map.voxels = std::move(world.map.voxels);
  unlevelled.map.objects = world.map.objects;
  unlevelled.run();
  EXPECT_EQ(unlevelled.at({0.5, 0.3, 0}), chair) << "only at the end";
  unlevelled.finish();
  EXPECT_EQ(unlevelled.at({0.5, 0.3, 0}), stuff(kFloor));
  EXPECT_EQ(unlevelled.at({-0.6, -0.2, 0.4}), chair);
}

TEST(ObjectMaintenance, DropsRarelySeenObjectsAndFillsThem) {
  for (const int times : {5, 6}) {
    World world(MaintenanceOptions{.floor_height_m = 0});
    const LabelSlot rare = world.seen(kChair, times, {}, 0.2F);
    const LabelSlot often = world.seen(kSofa, 50);
    add_to(world, {solid_box({-0.6, 0, 0}, {0, 0.6, 0.4}, often), solid_box({-0.4, 0.2, 0.2}, {-0.2, 0.4, 0.41}, rare)});
    ASSERT_EQ(world.at({-0.3, 0.3, 0.41}), rare);
    world.finish();
    EXPECT_EQ(world.at({-0.3, 0.3, 0.41}), times == 5 ? often : rare);
  }
}

// One detection of .9 is right more often than five of .2.
TEST(ObjectMaintenance, KeepsRarelySeenObjectsThatTheNetworksAreSureOf) {
  for (const float score : {0.7F, 0.9F}) {
    World world(MaintenanceOptions{.floor_height_m = 0});
    const LabelSlot once = world.seen(kChair, 1, {}, score);
    add_to(world, {solid_box({-0.4, 0.2, 0.2}, {-0.1, 0.5, 0.5}, once)});
    world.finish();
    EXPECT_EQ(world.ids().contains(once), score > 0.8F) << score;
  }
}

// The cabinet before the wall was hardly seen; the wall goes on where it hung, and its own faces are no wall.
TEST(ObjectMaintenance, FillsTheHoleOfADroppedObjectOnlyInThePlaneOfItsSurroundings) {
  World world(MaintenanceOptions{.floor_height_m = 0});
  const LabelSlot wall = stuff(test::kWall);
  const LabelSlot picture = world.seen(kChair, 1, {}, 0.2F);
  const LabelSlot cabinet = world.seen(kSofa, 1, {}, 0.2F);
  add_to(world, {solid_box({-1.1, 0.5, -0.1}, {1.1, 0.8, 1.1}, wall), solid_box({-0.9, 0.495, 0.2}, {-0.2, 0.8, 0.9}, picture),
                 solid_box({0.1, -0.1, 0.2}, {0.9, 0.8, 0.9}, cabinet)});
  world.finish();
  EXPECT_EQ(world.at({-0.55, 0.5, 0.55}), wall);
  const LabelSlot thing = world.at({0.5, -0.1, 0.55});
  EXPECT_NE(thing, wall);
  EXPECT_TRUE(world.map.labels.is_object(thing)) << "a thing without a class: that something is there is certain";
}

TEST(ObjectMaintenance, DoesNotOverruleWhatTheNetworksAreSureOf) {
  for (const float score : {0.5F, 0.95F}) {
    World world;
    const LabelSlot rug = world.seen(kBag, 20, {}, score);
    add_to(world, {solid_ground(kUp, 0, stuff(kFloor)), solid_box({-0.6, -0.5, -0.1}, {0.4, 0.5, 0.02}, rug)});
    ASSERT_EQ(world.at({-0.1, 0, 0.01}), rug);
    world.finish();
    EXPECT_EQ(world.at({-0.1, 0, 0.01}), score > 0.9F ? rug : stuff(kFloor)) << score;
  }
}

TEST(ObjectMaintenance, WithoutALabelledFrameMakesNoObjectAndLeavesTheMapAlone) {
  World world;
  add_to(world, {solid_ground(kUp, 0, LabelSlot::kUnknown), solid_box({-0.6, 0, 0}, {0, 0.6, 0.4}, LabelSlot::kUnknown)});
  const std::uint64_t before = world.map.voxels.hash();
  world.finish(0);
  EXPECT_EQ(world.map.voxels.hash(), before);
  EXPECT_EQ(world.map.objects.count(), 0U);
}

TEST(ObjectMaintenance, MakesNoThingOfSurfaceThatNoLabelledFrameLookedAt) {
  World world;
  const LabelSlot table = world.seen(test::kTable);
  // Voxels of its top lie less than carve_height_m above it.
  add_to(world, {solid_box({-0.6, -0.4, 0.55}, {0.6, 0.4, 0.715}, table), test::box_on_table(LabelSlot::kUnknown),
                 solid_box({-1, -0.8, -0.1}, {-0.7, 0.8, 0.4}, LabelSlot::kUnknown)});
  for (Slot slot = 0; slot < world.map.voxels.block_count(); ++slot) {
    test::BlockEdit block_edit(world.map.voxels.block(slot));
    BlockPlanes& block = *block_edit;
    for (std::size_t v = 0; v < kBlockVoxels; ++v) block.label_weight[v] = block.vote_sum[v] = block.label[v] == 0 ? 0.0F : 1.0F;
  }
  world.finish();
  EXPECT_EQ(world.ids(), std::set{table});
  EXPECT_EQ(world.at({0.1, 0.1, 0.9}), LabelSlot::kUnknown) << "on the table";
  EXPECT_EQ(world.at({-0.85, 0, 0.4}), LabelSlot::kUnknown) << "beside it";
}

TEST(ObjectMaintenance, AsksForFewerObservationsInShortRecordings) {
  for (const std::uint64_t frames : {35U, 105U}) {  // labelled ones, 1 of 35: once, three times
    World world;
    const LabelSlot twice = world.seen(kChair, 2);
    add_to(world, {solid_box({0, 0, 0}, {0.4, 0.4, 0.4}, twice)});
    world.finish(frames);
    EXPECT_EQ(world.ids().contains(twice), frames == 35);
  }
}

// Voxels that nothing surrounds become unknown, and a large unknown region becomes a thing without a class.
TEST(ObjectMaintenance, ADroppedObjectThatStandsAloneIsNoLongerThatObject) {
  World world;
  const LabelSlot rare = world.seen(kChair, 1);
  add_to(world, {solid_box({0, 0, 0}, {0.1, 0.1, 0.1}, rare), solid_box({-0.8, 0, 0}, {-0.2, 0.4, 0.4}, rare)});
  world.finish();
  EXPECT_EQ(world.count(rare), 0U);
}

TEST(ObjectMaintenance, LevelsTheFloor) {
  World world;
  const LabelSlot chair = world.seen(kChair);
  add_to(world, {solid_ground(kUp, 0, stuff(kFloor)), solid_box({-0.4, -0.4, -0.1}, {0, 0, 0.4}, chair)});
  SurfaceVoxels surface(world.map.voxels);
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    const Vec3d p = place_m(surface[i], world.map.voxels.voxel_size_m());
    if (p.x() > 0 && p.x() < 0.3 && p.y() < 0 && p.z() < 0.05) surface.relabel(i, chair);  // its shadow
  }
  surface.write_labels(world.map.voxels, world.votes);
  ASSERT_EQ(world.at({0.2, -0.2, 0}), chair);
  world.finish();
  EXPECT_EQ(world.at({0.2, -0.2, 0}), stuff(kFloor));
  EXPECT_EQ(world.at({-0.2, -0.2, 0.4}), chair) << "its seat is level, but no floor";
  EXPECT_EQ(world.at({-0.4, -0.2, 0.2}), chair) << "its side";
}

TEST(ObjectMaintenance, NamesLargeUnknownRegionsAndNotSmallOnes) {
  World world;
  add_to(world, {solid_box({-0.6, 0, 0}, {-0.2, 0.4, 0.4}, LabelSlot::kUnknown),
                 solid_box({0.3, 0, 0}, {0.4, 0.1, 0.1}, LabelSlot::kUnknown)});
  world.run();
  EXPECT_TRUE(world.ids().empty()) << "only at the end";
  world.finish();
  ASSERT_EQ(world.ids().size(), 1U);
  EXPECT_EQ(world.at({-0.4, 0.2, 0.4}), *world.ids().begin());
  EXPECT_EQ(world.at({0.35, 0.05, 0.1}), LabelSlot::kUnknown);
  EXPECT_EQ(world.map.objects.find(*world.ids().begin())->observations, 0U);
}

// The label set knows a class for them, or they stay without one.
TEST(ObjectMaintenance, ThingsThatNoNetworkKnowsAreOfTheClassOther) {
  std::vector<LabelClass> classes = test::labels().classes();
  classes.push_back({ClassId{9 + 1}, "other", true, {}});
  for (const LabelSet& labels : {test::labels(), LabelSet("room", classes)}) {
    World world({}, labels);
    const LabelSlot chair = world.seen(kChair);
    add_to(world,
           {solid_box({-1, 0, 0}, {-0.6, 0.4, 0.4}, chair), solid_box({0.2, -0.2, 0}, {0.8, 0.4, 0.4}, LabelSlot::kUnknown)});
    world.finish();
    const std::set<LabelSlot> ids = world.ids();
    ASSERT_EQ(ids.size(), 2U);
    const LabelSlot thing = *std::next(ids.begin());
    const LabelClass* other = labels.find("other");
    EXPECT_EQ(world.map.objects.class_of(thing), other == nullptr ? ClassId::kUnknown : other->id);
    EXPECT_EQ(world.map.objects.find(thing)->observations, 0U);
    EXPECT_TRUE(world.map.objects.probabilities(thing).empty());
    EXPECT_EQ(world.map.objects.class_of(chair), kChair);
  }
}

// Its share of the surface went to others; the mesh must not find the rest of it.
TEST(ObjectMaintenance, AnObjectThatHoldsNoSurfaceIsNoObject) {
  World world;
  const LabelSlot chair = world.seen(kChair);
  const LabelSlot behind = world.seen(kChair);
  add_to(world, {solid_box({-0.5, 0, 0}, {0.5, 0.4, 0.4}, chair)});
  for (Slot slot = 0; slot < world.map.voxels.block_count(); ++slot) {
    test::BlockEdit block_edit(world.map.voxels.block(slot));
    BlockPlanes& block = *block_edit;
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      if (block.weight[v] > 0 && block.distance[v] < -2 * world.map.voxels.voxel_size_m()) block.label[v] = number(behind);
    }
  }
  ASSERT_TRUE(ids_in_use(world.map.voxels)[number(behind)]);
  ASSERT_EQ(world.count(behind), 0U);
  world.finish();
  EXPECT_FALSE(ids_in_use(world.map.voxels)[number(behind)]);
  EXPECT_EQ(world.ids(), std::set{chair});
}

TEST(ObjectMaintenance, DropsSmallThingsThatNoMaskEverShowed) {
  for (const double edge_m : {0.05, 0.3}) {
    World world;
    const LabelSlot thing = *world.map.objects.create();
    add_to(world, {solid_box({0, 0, 0}, Vec3d::Constant(edge_m), thing)});
    world.finish();
    EXPECT_EQ(world.ids().contains(thing), edge_m == 0.3);
  }
}

}  // namespace
}  // namespace panoptic
