// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/agents.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "panoptic/base/json.h"
#include "panoptic/planning/agent_rules.h"
#include "panoptic/planning/ground.h"
#include "panoptic/planning/home_plan.h"
#include "panoptic/sim/home_truth.h"
#include "tests/expect_error.h"
#include "tests/places.h"
#include "tests/planning/furnished.h"
#include "tests/planning/planned_home.h"
#include "tests/planning/true_obstacles.h"
#include "tests/planning/true_surface.h"

namespace panoptic {
namespace {

using testing::HasSubstr;

bool is_on_feet(AgentState state) {
  return state == AgentState::kStanding || state == AgentState::kWalking || state == AgentState::kTurning;
}

// The two rooms of furnished.h: a seat is on the chair, a bed lies across the wall behind the shelf.
struct FurnishedRooms {
  PanopticMap map = test::furnished_map();
  UpFrame frame = up_frame(map, Vec3d::UnitZ());
  Ground ground = ground_of(map, frame, surface_samples(map.voxels), {});
  RecastMesh mesh{ground.columns, {}};
  HomePlan home;

  FurnishedRooms() {
    home.seats.push_back({.position = {1.3, -0.7, 0.45}, .facing = -Vec3d::UnitX(), .height_m = 0.45});
    home.lying_places.push_back(
        {.polygon = {}, .center = {-0.3, -1.8, 0.4}, .axis = Vec3d::UnitX(), .length_m = 1.9, .width_m = 0.8, .height_m = 0.4});
  }
};

const FurnishedRooms& rooms() {
  static const FurnishedRooms kRooms;
  return kRooms;
}

AgentsRun live(const AgentOptions& options) { return let_live(rooms().mesh, rooms().home, {}, options); }

TEST(Agents, WhoIsOnFootKeepsAwayFromWhatStandsThereAndFromOthers) {
  constexpr double kSlack_m = 0.024;
  const AgentsRun run = live({.count = 4, .seconds = 120, .seed = 2});
  ASSERT_EQ(run.agents.size(), 4U);
  EXPECT_GT(run.totals().walked_m, 50);
  for (std::size_t i = 0; i < run.agents[0].samples.size(); ++i) {
    for (const AgentTrack& one : run.agents) {
      const AgentSample& s = one.samples[i];
      if (!is_on_feet(s.state)) continue;
      ASSERT_TRUE(test::may_stand(s.position.head<2>(), AgentSize{}.radius_m - kSlack_m)) << s.position.transpose();
      ASSERT_NEAR(s.position.z(), 0, 0.03);
      for (const AgentTrack& other : run.agents) {
        if (&other == &one || !is_on_feet(other.samples[i].state)) continue;
        ASSERT_GT((other.samples[i].position - s.position).head<2>().norm(), AgentSize{}.radius_m) << s.time_s;
      }
    }
  }
}

TEST(Agents, WhoSitsIsOnTheSeatAndFacesAsItDoesAndWhoLiesIsOnTheBed) {
  const AgentsRun run = live({.count = 2, .seconds = 240, .seed = 4});
  EXPECT_GT(run.totals().seats, 0);
  EXPECT_GT(run.totals().beds, 0);
  for (const AgentTrack& one : run.agents) {
    for (const AgentSample& s : one.samples) {
      if (s.state == AgentState::kSitting) {
        ASSERT_NEAR((s.position - Vec3d(1.3, -0.7, 0)).norm(), 0, 1e-9);
        ASSERT_NEAR(s.facing.x(), -1, 1e-9);
      } else if (s.state == AgentState::kLying) {
        ASSERT_NEAR((s.position - Vec3d(-0.3, -1.8, 0)).norm(), 0, 0.1);
        ASSERT_NEAR(s.facing.x(), -1, 1e-9);  // the feet point away from the head
      }
    }
  }
}

TEST(Agents, TheSameSeedGivesTheSameLifeAndAnotherOneAnother) {
  const auto places = [](std::uint32_t seed) {
    std::vector<double> all;
    for (const AgentTrack& one : live({.count = 3, .seconds = 30, .seed = seed}).agents) {
      for (const AgentSample& s : one.samples) all.insert(all.end(), {s.position.x(), s.position.y(), s.facing.x()});
    }
    return all;
  };
  EXPECT_EQ(places(1), places(1));
  EXPECT_NE(places(1), places(2));
}

TEST(Agents, ForWhomThereIsNoRoomIsTold) {
  const AgentsRun run = live({.count = 32, .seconds = 0.1});
  EXPECT_LT(run.agents.size(), 32U);
  EXPECT_GT(run.agents.size(), 3U);
  EXPECT_THAT(run.notes, testing::ElementsAre(HasSubstr("of 32 agents")));
  const AgentsRun without = let_live(rooms().mesh, {}, {}, {.count = 1, .seconds = 60});
  EXPECT_EQ(without.totals().seats, 0);
  EXPECT_THAT(without.notes, testing::ElementsAre(HasSubstr("no seats")));
}

TEST(Agents, NumbersOutOfRangeAreRefused) {
  EXPECT_THAT(test::error_of([] { check(AgentOptions{.count = 0}); }), HasSubstr("0 agents: it takes 1 to 32"));
  EXPECT_THAT(test::error_of([] { check(AgentOptions{.count = 33}); }), HasSubstr("33 agents"));
  EXPECT_THAT(test::error_of([] { check(AgentOptions{.count = 5, .seconds = 0}); }), HasSubstr("5 agents and 0 insects for 0 s"));
  EXPECT_THAT(test::error_of([] { check(AgentOptions{.count = 5, .seconds = std::nan("")}); }), HasSubstr("more than 0"));
  EXPECT_THAT(test::error_of([] { check(AgentOptions{.count = 5, .seconds = 7201}); }), HasSubstr("at most 7200 s"));
  EXPECT_THAT(test::error_of([] { check(AgentOptions{.count = 5, .insects = 33}); }), HasSubstr("33 insects: it takes 0 to 32"));
  EXPECT_THAT(test::error_of([] { check(AgentOptions{.count = 5, .insects = -1}); }), HasSubstr("-1 insects"));
  EXPECT_THAT(test::error_of([] { check(AgentOptions{.count = 5, .insects = 5, .seconds = 7200}); }),
              HasSubstr("at most 3600 s"));
  check(AgentOptions{.count = 5, .seconds = 7200});
}

// The page's figures and these are alike only as long as their numbers are.
TEST(Agents, TheirRulesAreThoseOfThePage) {
  namespace r = agent_rules;
  const auto range = [](const r::Range& x) { return Json::array({x.low, x.high}); };
  const Json here = {
      {"steps_per_s", r::kStepsPer_s},
      {"most_agents", r::kMostAgents},
      {"heights_m", r::kHeights_m},
      {"walk",
       {{"radius_m", r::kWalk.radius_m},
        {"height_m", r::kWalk.height_m},
        {"acceleration_m_s2", r::kWalk.acceleration_m_s2},
        {"speed_m_s", r::kWalk.speed_m_s},
        {"slowest_share", r::kSlowestShare},
        {"looks_m", r::kWalk.looks_m},
        {"optimizes_m", r::kWalk.optimizes_m},
        {"separation", r::kWalk.separation}}},
      {"turn_rad_s", r::kTurn_rad_s},
      {"turn_walking_rad_s", r::kTurnWalking_rad_s},
      {"arrived_m", r::kArrived_m},
      {"patience_s", r::kPatience_s},
      {"stuck_s", r::kStuck_s},
      {"sit_down_s", r::kSitDown_s},
      {"lie_down_s", r::kLieDown_s},
      {"spots",
       {{"distances_m", r::kSpotDistances_m},
        {"turns_rad", r::kSpotTurns_rad},
        {"turn_costs_m", r::kTurnCosts_m},
        {"off_m", r::kSpotOff_m}}},
      {"any_spot", {{"ahead_m", r::kAnySpotAhead_m}, {"off_m", r::kAnySpotOff_m}, {"farthest_m", r::kAnySpotFarthest_m}}},
      {"bed", {{"edge_m", r::kBedEdge_m}, {"head_share", r::kHeadShare}}},
      {"tries", r::kTries},
      {"apart_m", r::kApart_m},
      {"bored_s", range(r::kBored_s)},
      {"rests_s", range(r::kRests_s)},
      {"sits_share", r::kSitsShare},
      {"lies_share", r::kLiesShare},
      {"in_the_way_m", r::kInTheWay_m},
      {"aside_m", range(r::kAside_m)},
      {"insect",
       {{"speed_m_s", range(r::kInsectSpeed_m_s)},
        {"turn_rad_s", r::kInsectTurn_rad_s},
        {"turns_first_rad", r::kInsectTurnsFirst_rad},
        {"rests_s", range(r::kInsectRests_s)},
        {"farthest_m", r::kInsectFarthest_m},
        {"tries", r::kInsectTries},
        {"walls", r::kInsectWalls}}}};
  const Json page = read_json_file(test::source_folder() / "apps/viewer/web/src/play/rules.json");
  EXPECT_EQ(nlohmann::json::parse(page.dump()), nlohmann::json::parse(here.dump()));
  EXPECT_EQ(r::kWalk.radius_m, AgentSize{}.radius_m);
}

// A simulated home that was mapped with perfect depth and masks, and five people in it for ten minutes.
class AgentsOfAHome : public testing::Test {
 protected:
  static constexpr double kRadius_m = AgentSize{}.radius_m;
  static constexpr HomeOptions kHome{5, 1};

  struct Lived {
    Lived() : simulation({.seed = kHome.seed, .rooms = kHome.rooms, .frames = 150, .noise = "none"}) {
      const auto mapper = test::map_home(simulation, Pose::Identity());
      const PanopticMap& map = mapper->map();
      const UpFrame frame = up_frame(map, Vec3d::UnitZ());
      const SurfaceByBlock surface = surface_samples(map.voxels);
      const Ground ground = ground_of(map, frame, surface, {});
      const RecastMesh mesh(ground.columns, {});
      const AgentOptions options{.count = 5, .insects = 6, .seconds = 600};
      run = let_live(mesh, plan_home(map, surface, frame.grid_from_world), {}, options);
      run.insects = let_crawl(wall_meshes(map, frame, surface), surface, frame, options);
      const Pose home_from_grid = frame.grid_from_world.inverse();
      for (AgentTrack& one : run.agents) {
        for (AgentSample& s : one.samples) {
          s.position = home_from_grid * s.position;
          s.facing = (home_from_grid.linear() * Vec3d(s.facing.x(), s.facing.y(), 0)).head<2>();
        }
      }
      for (InsectTrack& one : run.insects) {
        for (InsectSample& s : one.samples) s.position = home_from_grid * s.position;
      }
    }
    Simulation simulation;
    AgentsRun run;
  };

  static const Lived& lived() {
    static const Lived kLived;
    return kLived;
  }

  template <typename Visit>
  static void visit_samples(const Visit& visit) {
    for (const AgentTrack& one : lived().run.agents) std::for_each(one.samples.begin(), one.samples.end(), visit);
  }
};

TEST_F(AgentsOfAHome, NobodyWalksThroughWhatIsTrulyThereInTenMinutesOfFive) {
  constexpr double kSlack_m = 0.024;
  const Home& home = lived().simulation.home();
  const test::TrueObstacles obstacles(home.scene, AgentSize{}.climb_m + 0.001, AgentSize{}.height_m);
  const AgentTotals totals = lived().run.totals();
  EXPECT_EQ(totals.agents, 5);
  EXPECT_GT(totals.walked_m, 500);
  EXPECT_LE(totals.gave_up, 2);
  double least_m = 1;
  double highest_m = 0;
  visit_samples([&](const AgentSample& s) {
    if (!is_on_feet(s.state)) return;
    least_m = std::min(least_m, obstacles.clearance_m(s.position.head<2>()));
    highest_m = std::max(highest_m, std::abs(s.position.z()));
  });
  RecordProperty("least_m", std::to_string(least_m));
  EXPECT_GE(least_m, kRadius_m - kSlack_m);
  EXPECT_LE(highest_m, 0.03);
}

// Who sits down or gets up is nearer to the seat than the radius, and still on its side of every wall.
TEST_F(AgentsOfAHome, NobodyIsInAWallWhileSittingOrLying) {
  const LabelSet labels = load_label_set("scannet20");
  const test::TrueObstacles walls(lived().simulation.home().scene, AgentSize{}.climb_m, AgentSize{}.height_m,
                                  labels.find("wall")->id);
  double least_m = 1;
  visit_samples([&](const AgentSample& s) { least_m = std::min(least_m, walls.clearance_m(s.position.head<2>())); });
  RecordProperty("least_m", std::to_string(least_m));
  EXPECT_GE(least_m, 0.1);
}

TEST_F(AgentsOfAHome, WhoSitsIsOverATrueSeatAndFacesAsItDoes) {
  const PlanTruth truth = home_truth(lived().simulation.home(), kHome);
  EXPECT_GT(lived().run.totals().seats, 20);
  double farthest_m = 0;
  double most_off_deg = 0;
  visit_samples([&](const AgentSample& s) {
    if (s.state != AgentState::kSitting) return;
    const auto from = [&](const TrueSeat& seat) { return (seat.position - s.position).head<2>().norm(); };
    const auto seat = std::min_element(truth.seats.begin(), truth.seats.end(),
                                       [&](const TrueSeat& a, const TrueSeat& b) { return from(a) < from(b); });
    farthest_m = std::max(farthest_m, from(*seat));
    const double cosine = std::clamp(seat->facing.normalized().dot(s.facing.normalized()), -1.0, 1.0);
    most_off_deg = std::max(most_off_deg, std::acos(cosine) * 180 / std::numbers::pi);
  });
  RecordProperty("farthest_m", std::to_string(farthest_m));
  RecordProperty("most_off_deg", std::to_string(most_off_deg));
  EXPECT_LE(farthest_m, 0.15);
  EXPECT_LE(most_off_deg, 20);
}

// Some of them crawl along the frames of windows and doors, which lie in the walls.
TEST_F(AgentsOfAHome, InsectsAreWithinTwoCentimetresOfTheTrueWalls) {
  const LabelSet labels = load_label_set("scannet20");
  const Scene& scene = lived().simulation.home().scene;
  const test::TrueSurface walls(scene, labels.find("wall")->id);
  const test::TrueSurface in_walls[] = {{scene, labels.find("window")->id}, {scene, labels.find("door")->id}};
  std::vector<double> off_m;
  std::size_t on_wall = 0;
  ASSERT_EQ(lived().run.insects.size(), 6U);
  for (const InsectTrack& one : lived().run.insects) {
    ASSERT_EQ(one.samples.size(), 6001U);
    EXPECT_GT(one.crawled_m, 10);
    EXPECT_LT(one.farthest_m, 0.04);
    for (const InsectSample& s : one.samples) {
      const double wall_m = walls.distance_m(s.position);
      on_wall += wall_m <= 0.02 ? 1 : 0;
      off_m.push_back(std::min({wall_m, in_walls[0].distance_m(s.position), in_walls[1].distance_m(s.position)}));
    }
  }
  std::sort(off_m.begin(), off_m.end());
  RecordProperty("on_wall", std::to_string(on_wall));
  RecordProperty("most_m", std::to_string(off_m.back()));
  EXPECT_GT(on_wall, off_m.size() * 9 / 10);
  EXPECT_LE(off_m[off_m.size() * 99 / 100], 0.02);
  EXPECT_LE(off_m.back(), 0.03);
}

TEST(Agents, InsectsLiveTheSameLifeForTheSameSeedAndDisturbNobody) {
  const SurfaceByBlock surface = surface_samples(rooms().map.voxels);
  const std::vector<WallMesh> walls = wall_meshes(rooms().map, rooms().frame, surface);
  const auto places = [&](std::uint32_t seed) {
    std::vector<double> all;
    for (const InsectTrack& one :
         let_crawl(walls, surface, rooms().frame, {.count = 1, .insects = 3, .seconds = 30, .seed = seed})) {
      for (const InsectSample& s : one.samples) all.insert(all.end(), {s.position.x(), s.position.y(), s.position.z()});
    }
    return all;
  };
  EXPECT_EQ(places(1).size(), 3U * 3 * 301);
  EXPECT_EQ(places(1), places(1));
  EXPECT_NE(places(1), places(2));
  EXPECT_TRUE(let_crawl({}, surface, rooms().frame, {.count = 1, .insects = 3}).empty());
}

}  // namespace
}  // namespace panoptic
