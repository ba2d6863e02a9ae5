// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A home with perfect masks against its truth, in a world whose axes lie along nothing.
#include "panoptic/home_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/planning.h"
#include "tests/fresh_folder.h"
#include "tests/planning/planned_home.h"

namespace panoptic::test {
namespace {

using ::testing::Each;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Le;

TEST(HomePlan, OfATurnedHomeAgreesWithTheTruth) {
  constexpr HomeOptions kHome{3, 1};
  const Simulation simulation({.seed = kHome.seed, .rooms = kHome.rooms, .frames = 120, .noise = "none"});
  Pose turned_from_world = Pose::Identity();
  turned_from_world.linear() =
      (Eigen::AngleAxisd(0.5, Vec3d::UnitZ()) * Eigen::AngleAxisd(0.25, Vec3d(1, 0.3, 0).normalized())).toRotationMatrix();
  turned_from_world.translation() = Vec3d(0.5, -1, 0.5);
  const auto mapper = map_home(simulation, turned_from_world);
  const PanopticMap& map = mapper->map();
  const UpFrame frame = up_frame(map, turned_from_world.linear() * Vec3d::UnitZ());
  const HomePlan plan = plan_home(map, frame.grid_from_world);

  const PlanScores scores = score(in_world(plan, turned_from_world), home_truth(simulation.home(), kHome));
  SCOPED_TRACE(scores.text());
  EXPECT_GE(scores.seats.f1(), 0.9);
  EXPECT_THAT(scores.seats.errors, Each(Le(20)));
  EXPECT_GE(scores.tables.f1(), 0.9);
  EXPECT_THAT(scores.tables.errors, Each(Gt(0.8)));
  EXPECT_GE(scores.doors.f1(), 0.85);
  EXPECT_GE(scores.rooms.f1(), 0.9);

  const auto folder = fresh_folder();
  write_home_plan(plan, map.labels, folder);
  EXPECT_EQ(read_json_file(folder / "affordances.json").at("seats").size(), plan.seats.size());
  EXPECT_EQ(read_json_file(folder / "rooms.json").at("rooms").size(), plan.rooms.size());
  const std::string drawing = read_file(folder / "floorplan.svg");
  EXPECT_THAT(drawing, HasSubstr("</svg>"));
  EXPECT_THAT(drawing, HasSubstr("m²"));
}

}  // namespace
}  // namespace panoptic::test
