// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/moving_home.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "panoptic/sim/catalogue.h"
#include "panoptic/sim/clearance_map.h"
#include "panoptic/sim/simulation.h"
#include "panoptic/sim/walk.h"
#include "tests/expect_error.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;

constexpr Camera kCamera{640, 480, 577.87, 577.87, 319.5, 239.5};

MovingHome home_of(Dynamics dynamics, int rooms = 2, int frames = 1500) {
  return make_moving_home({{.seed = 2, .rooms = rooms}, frames, dynamics}, Catalogue(), kCamera);
}

// Shared by the tests that only look.
const MovingHome& busy() {
  static const MovingHome kHome = home_of(Dynamics::kBusy);
  return kHome;
}

TEST(MovingHome, NothingMovesUnlessAskedTo) {
  const MovingHome world = home_of(Dynamics::kStatic, 1, 20);
  EXPECT_TRUE(world.changes.empty());
  EXPECT_TRUE(world.movers.empty());
  EXPECT_EQ(world.presences.size(), 1U);
  EXPECT_EQ(labels_of(world).name(), "scannet20");
}

TEST(MovingHome, IsTheSameAgain) {
  const MovingHome again = home_of(Dynamics::kBusy);
  ASSERT_EQ(again.changes.size(), busy().changes.size());
  for (std::size_t i = 0; i < again.changes.size(); ++i) {
    EXPECT_EQ(again.changes[i].frame, busy().changes[i].frame);
    EXPECT_EQ(again.changes[i].instance, busy().changes[i].instance);
  }
  ASSERT_EQ(again.movers.size(), busy().movers.size());
  for (std::size_t m = 0; m < again.movers.size(); ++m) {
    for (std::size_t frame = 0; frame < again.path.size(); frame += 97) {
      EXPECT_EQ(again.movers[m].poses[frame].at, busy().movers[m].poses[frame].at);
    }
  }
}

// Every place that anything ever takes counts.
TEST(MovingHome, NobodyWalksThroughFurniture) {
  ASSERT_FALSE(busy().movers.empty());
  const ClearanceMap clearance = walking_clearance(busy().home, 1.95);
  std::set<Activity> seen;
  for (const Mover& mover : busy().movers) {
    ASSERT_EQ(mover.poses.size(), busy().path.size());
    for (std::size_t frame = 0; frame < mover.poses.size(); ++frame) {
      EXPECT_GT(clearance.at(mover.poses[frame].at), 0.08) << frame;
      seen.insert(mover.activities[frame]);
    }
  }
  EXPECT_TRUE(seen.contains(Activity::kWalking));
  EXPECT_TRUE(seen.contains(Activity::kStanding));
}

TEST(MovingHome, MoversKeepToTheSpeedsOfPeopleAndApartFromTheCamera) {
  std::size_t near = 0;
  for (const Mover& mover : busy().movers) {
    for (std::size_t frame = 1; frame < mover.poses.size(); ++frame) {
      EXPECT_LT((mover.poses[frame].at - mover.poses[frame - 1].at).norm() * 30, 1.4) << frame;
      near += (mover.poses[frame].at - busy().path[frame].translation().head<2>()).norm() < 0.4 ? 1 : 0;
    }
  }
  EXPECT_LT(near, busy().path.size() / 50);
}

TEST(MovingHome, NothingChangesBeforeTheCamera) {
  const MovingHome& world = busy();
  ASSERT_FALSE(world.changes.empty());
  const Renderer renderer(world.home.scene, world.presences);
  const Camera camera = resized(kCamera, 160, 120);
  for (const Change& change : world.changes) {
    for (std::size_t frame = change.frame - 4; frame < change.frame + 4; ++frame) {
      const Glance glance = renderer.look(camera, world.path[frame], world.presence_at(frame));
      const auto& there = frame < change.frame ? change.before : change.after;
      if (!there) continue;
      const auto pixels = std::count(glance.object.pixels().begin(), glance.object.pixels().end(), *there);
      EXPECT_LT(pixels, 40) << "frame " << frame << ", object " << *there;
    }
  }
}

TEST(MovingHome, EveryChangeIsInTheTruthWithItsPlaces) {
  const MovingHome& world = busy();
  const Renderer renderer(world.home.scene, world.presences);
  const DynamicsTruth truth = dynamics_truth(world, renderer, kCamera, "busy");
  ASSERT_EQ(truth.changes.size(), world.changes.size());
  std::size_t shown = 0;
  for (const TrueChange& change : truth.changes) {
    EXPECT_EQ(change.old_box.has_value(), change.kind != EventKind::kAdded);
    EXPECT_EQ(change.new_box.has_value(), change.kind != EventKind::kRemoved);
    if (change.old_box && change.new_box) {
      EXPECT_LT(change.old_box->intersection(*change.new_box).sizes().minCoeff(), 0.05);
    }
    const PlaceViews& views = change.old_box ? change.old_place : change.new_place;
    if (views.first_after) {
      EXPECT_GE(*views.first_after, change.frame);
    }
    shown += views.before > 0 && views.after > 0 ? 1 : 0;
  }
  EXPECT_GE(2 * shown, truth.changes.size());
  EXPECT_EQ(truth.movers.size(), world.movers.size());
  for (const TrueThing& thing : truth.things) {
    ASSERT_FALSE(thing.stays.empty());
    if (thing.stays.size() == 2) {
      EXPECT_EQ(thing.stays[0].last_frame + 1, thing.stays[1].first_frame);
    }
  }
}

TEST(MovingHome, TheHomeAtTheEndLacksWhatIsGone) {
  const MovingHome& world = busy();
  const Home home = final_home(world);
  for (const Change& change : world.changes) {
    const auto count = std::count_if(home.scene.objects.begin(), home.scene.objects.end(),
                                     [&](const SceneObject& object) { return object.instance == change.instance; });
    EXPECT_EQ(count, change.after ? 1 : 0);
  }
}

TEST(MovingHome, UnknownDynamicsAreRefusedWithTheNames) {
  EXPECT_THAT(error_of([] { dynamics_of("wild"); }), HasSubstr("static, people, changes, busy"));
  EXPECT_THAT(error_of([] { parse_simulation("sim:1,dynamics=wild"); }), HasSubstr("'wild'"));
  EXPECT_EQ(parse_simulation("sim:1,dynamics=busy").dynamics, "busy");
}

// The recording of a home with people is that of the same home without, wherever they are not.
TEST(Dynamics, PeopleChangeNoPixelThatDoesNotShowThem) {
  SimulationOptions options{.seed = 3, .rooms = 1, .frames = 60, .noise = "none"};
  const Simulation still(options);
  options.dynamics = "people";
  const Simulation people(options);
  std::size_t moving = 0;
  for (std::size_t frame = 0; frame < still.size(); frame += 7) {
    const SimulatedFrame a = still.simulate(frame);
    const SimulatedFrame b = people.simulate(frame);
    EXPECT_TRUE(a.rendering.fate.empty());
    for (std::size_t i = 0; i < a.rendering.depth.size(); ++i) {
      if (b.rendering.fate[i] == Fate::kMoves) {
        ++moving;
        continue;
      }
      ASSERT_EQ(a.rendering.depth[i], b.rendering.depth[i]);
      ASSERT_EQ(a.rendering.color[i], b.rendering.color[i]);
      ASSERT_EQ(a.rendering.instance[i], b.rendering.instance[i]);
    }
  }
  EXPECT_GT(moving, 100U);
}

}  // namespace
}  // namespace panoptic::test
