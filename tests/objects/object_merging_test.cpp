// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_maintenance.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/objects/maintained_world.h"

namespace panoptic {
namespace {

using test::add_to;
using test::box_on_table;
using test::kBag;
using test::kChair;
using test::kFloor;
using test::kSofa;
using test::kTable;
using test::kUp;
using test::Solid;
using test::solid_box;
using test::solid_ground;
using test::stuff;
using test::table_top;
using test::World;

// Two halves of one chair, side by side, the left one larger.
struct Halves {
  LabelSlot larger;
  LabelSlot smaller;
};

Halves add_halves(World& world, ClassId left, ClassId right, double gap_m = 0) {
  const Halves halves{world.seen(left), world.seen(right)};
  add_to(world, {solid_box({-0.4, 0, 0}, {0, 0.4, 0.4}, halves.larger),
                 solid_box({gap_m, 0, 0}, {0.12 + gap_m, 0.4, 0.4}, halves.smaller)});
  return halves;
}

TEST(ObjectMaintenance, MergesTwoHalvesOfAChair) {
  World world;
  const Halves halves = add_halves(world, kChair, kChair);
  const std::size_t voxels = world.count(halves.larger) + world.count(halves.smaller);
  world.run();
  EXPECT_EQ(world.ids(), std::set{halves.larger});
  EXPECT_EQ(world.count(halves.larger), voxels);
  EXPECT_EQ(world.map.objects.survivor(halves.smaller), halves.larger);
  EXPECT_EQ(world.map.objects.find(halves.smaller), nullptr);
  EXPECT_EQ(world.map.objects.find(halves.larger)->observations, 40U);
}

TEST(ObjectMaintenance, DoesNotMergeOtherClassesNorDistantThingsNorThingsWithoutAClass) {
  World other;
  add_halves(other, kChair, kSofa);
  other.run();
  EXPECT_EQ(other.ids().size(), 2U);
  World distant;
  add_halves(distant, kChair, kChair, 0.2);
  distant.run();
  EXPECT_EQ(distant.ids().size(), 2U);
  World nameless;
  const Halves halves{*nameless.map.objects.create(), *nameless.map.objects.create()};
  add_to(nameless,
         {solid_box({-0.4, 0, 0}, {0, 0.4, 0.4}, halves.larger), solid_box({0, 0, 0}, {0.2, 0.4, 0.4}, halves.smaller)});
  nameless.run();
  EXPECT_EQ(nameless.ids().size(), 2U);
}

TEST(ObjectMaintenance, DoesNotMergeWhatWasOftenSeenAsTwoMasksAtOnce) {
  for (const int together : {4, 5}) {  // of 20 observations each; the limit is a fifth
    World world;
    const Halves halves = add_halves(world, kChair, kChair);
    const std::vector both = {world.map.objects.id_of(halves.smaller), world.map.objects.id_of(halves.larger)};
    for (int t = 0; t < together; ++t) world.maintenance.saw_together(both);
    world.run();
    EXPECT_EQ(world.ids().size(), together == 4 ? 1U : 2U);
    EXPECT_EQ(world.map.objects.survivor(halves.smaller), together == 4 ? halves.larger : halves.smaller);
  }
}

// Being apart is inherited: what was told apart from a part was told apart from the whole.
TEST(ObjectMaintenance, KeepsApartWhatWasCovisibilityWithAMergedPart) {
  World world;
  const LabelSlot large = world.seen(kChair);
  const LabelSlot part = world.seen(kChair);
  const LabelSlot neighbour = world.seen(kChair);
  for (int t = 0; t < 15; ++t)
    world.maintenance.saw_together(std::vector{world.map.objects.id_of(part), world.map.objects.id_of(neighbour)});
  add_to(world, {solid_box({-0.4, 0, 0}, {0, 0.4, 0.4}, large), solid_box({0, 0, 0}, {0.06, 0.4, 0.4}, part),
                 solid_box({0.06, 0, 0}, {0.18, 0.4, 0.4}, neighbour)});
  world.run();
  world.run();
  world.run();
  EXPECT_EQ(world.map.objects.survivor(part), large);
  EXPECT_EQ(world.ids(), (std::set{large, neighbour}));
}

TEST(ObjectMaintenance, MergesAChainOfPiecesAndEveryIdResolvesToTheSurvivor) {
  World world;
  std::vector<LabelSlot> pieces;
  std::vector<Solid> solids;
  for (int n = 0; n < 6; ++n) {
    pieces.push_back(world.seen(kSofa));
    solids.push_back(solid_box({-0.6 + 0.1 * n, 0, 0}, {-0.5 + 0.1 * n, 0.4 + 0.02 * n, 0.4}, pieces.back()));
  }
  add_to(world, solids);
  world.finish();
  ASSERT_EQ(world.ids().size(), 1U);
  for (const LabelSlot piece : pieces) EXPECT_EQ(world.map.objects.survivor(piece), *world.ids().begin());
  EXPECT_EQ(world.map.objects.count(), 1U);
  EXPECT_EQ(world.map.objects.find(*world.ids().begin())->observations, 120U);
}

TEST(ObjectMaintenance, MakesABoxOnATableAnObjectThatKeepsItsId) {
  for (const bool told_apart : {false, true}) {
    World world;
    const LabelSlot table = told_apart ? world.seen(kTable) : stuff(kTable);
    add_to(world, {table_top(table), box_on_table(table)});
    world.run();
    const LabelSlot box = world.at({0.1, 0.1, 0.9});
    EXPECT_NE(box, table);
    ASSERT_NE(world.map.objects.find(box), nullptr);
    EXPECT_EQ(world.map.objects.class_of(box), ClassId::kUnknown);
    EXPECT_EQ(world.at({-0.3, -0.2, 0.7}), table);
    EXPECT_EQ(world.at({0, 0.1, 0.85}), box) << "its side";
    const std::uint64_t hash = world.map.voxels.hash();
    world.run();
    EXPECT_EQ(world.map.voxels.hash(), hash);
    world.finish();
    EXPECT_EQ(world.at({0.1, 0.1, 0.9}), box);
    EXPECT_EQ(world.map.objects.count(), told_apart ? 2U : 1U);
  }
}

// A carved thing grows with what is seen of it later.
TEST(ObjectMaintenance, GivesNewSurfaceOfACarvedThingToIt) {
  World world;
  add_to(world, {table_top(stuff(kTable)), box_on_table(stuff(kTable))});
  world.run();
  const LabelSlot box = world.at({0.1, 0.1, 0.9});
  SurfaceVoxels surface(world.map.voxels);
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    const Vec3d p = place_m(surface[i], world.map.voxels.voxel_size_m());
    if (surface[i].label == box && p.x() > 0.12) surface.relabel(i, p.y() > 0.1 ? stuff(kTable) : LabelSlot::kUnknown);
  }
  surface.write_labels(world.map.voxels, world.votes);
  world.run();
  EXPECT_EQ(world.at({0.18, 0.18, 0.9}), box);
  EXPECT_EQ(world.at({0.18, 0.02, 0.9}), box);
  EXPECT_EQ(world.map.objects.count(), 1U);
}

TEST(ObjectMaintenance, LeavesThingsWithAClassOnTheTableAlone) {
  World world;
  const LabelSlot bag = world.seen(kBag);
  add_to(world, {table_top(stuff(kTable)), box_on_table(bag)});
  const std::size_t before = world.count(bag);
  world.run();
  EXPECT_EQ(world.count(bag), before);
}

// Its class was seen too seldom to be believed, but that something stands there is certain.
TEST(ObjectMaintenance, ARarelySeenObjectOnATableIsAThingWithoutAClass) {
  for (const int times : {2, 20}) {
    World world;
    const LabelSlot bag = world.seen(kBag, times);
    add_to(world, {table_top(stuff(kTable)), box_on_table(bag)});
    world.finish();
    const LabelSlot thing = world.at({0.1, 0.1, 0.9});
    EXPECT_EQ(thing == bag, times == 20);
    ASSERT_NE(world.map.objects.find(thing), nullptr);
    EXPECT_EQ(world.map.objects.class_of(thing), times == 20 ? kBag : ClassId::kUnknown);
  }
}

TEST(ObjectMaintenance, CarvesNothingOutOfFloorsNorWhenToldNotTo) {
  World floor;
  add_to(floor, {solid_ground(kUp, 0, stuff(kFloor)), solid_box({0, 0, -0.1}, {0.2, 0.2, 0.2}, stuff(kFloor))});
  floor.run();
  EXPECT_TRUE(floor.ids().empty()) << "a floor is no support";
  World off(MaintenanceOptions{.carve = false});
  add_to(off, {table_top(stuff(kTable)), box_on_table(stuff(kTable))});
  off.run();
  off.finish();
  EXPECT_TRUE(off.ids().empty());
}

}  // namespace
}  // namespace panoptic
