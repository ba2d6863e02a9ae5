// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/jumps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "panoptic/base/json.h"
#include "panoptic/sim/simulation.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using testing::HasSubstr;

constexpr std::size_t kFrames = 600;

// Round a table of 2 m, twice, looking outwards.
std::vector<Pose> round_a_table() {
  std::vector<Pose> path;
  for (std::size_t i = 0; i < kFrames; ++i) {
    const double angle = 4 * std::numbers::pi * static_cast<double>(i) / kFrames;
    Pose pose = Pose::Identity();
    pose.translation() = Vec3d(2 * std::cos(angle), 2 * std::sin(angle), 1.5);
    pose.linear() = Eigen::AngleAxisd(angle, Vec3d::UnitZ()).toRotationMatrix();
    path.push_back(pose);
  }
  return path;
}

double distance_m(const Pose& a, const Pose& b) { return (a.translation() - b.translation()).norm(); }

TEST(Jumps, CarryTheCameraElsewhereAndNowhereElseIsAStep) {
  const std::vector<Pose> path = round_a_table();
  const JumpingPath jumping = with_jumps(path, 6, 7);
  ASSERT_EQ(jumping.poses.size(), kFrames);
  ASSERT_EQ(jumping.jumps.size(), 6U);
  std::vector<std::size_t> steps;
  for (std::size_t i = 1; i < kFrames; ++i) {
    if (distance_m(jumping.poses[i - 1], jumping.poses[i]) > 0.1) steps.push_back(i);
  }
  std::vector<std::size_t> frames;
  for (const Jump& jump : jumping.jumps) {
    frames.push_back(jump.frame);
    EXPECT_EQ(jump.from.matrix(), jumping.poses[jump.frame - 1].matrix());
    EXPECT_EQ(jump.to.matrix(), jumping.poses[jump.frame].matrix());
    EXPECT_GT(distance_m(jump.from, jump.to), 0.8);
  }
  EXPECT_EQ(steps, frames);
  EXPECT_GE(frames.front(), kFrames / 3);
  for (std::size_t j = 1; j < frames.size(); ++j) EXPECT_GT(frames[j] - frames[j - 1], 40U);
}

TEST(Jumps, StayBesideThePath) {
  const std::vector<Pose> path = round_a_table();
  for (const Pose& pose : with_jumps(path, 5, 11).poses) {
    const auto nearest = std::min_element(
        path.begin(), path.end(), [&](const Pose& a, const Pose& b) { return distance_m(a, pose) < distance_m(b, pose); });
    EXPECT_LT(distance_m(*nearest, pose), 0.14);
    EXPECT_TRUE(is_rigid(pose, 1e-9));
  }
}

TEST(Jumps, GoMostlyWhereTheCameraWasBefore) {
  const std::vector<Pose> path = round_a_table();
  const JumpingPath jumping = with_jumps(path, 6, 3);
  for (const Jump& jump : jumping.jumps) {
    const auto end = jumping.poses.begin() + static_cast<std::ptrdiff_t>(jump.frame);
    const bool is_near = std::any_of(jumping.poses.begin(), end, [&](const Pose& p) { return distance_m(p, jump.to) < 0.4; });
    EXPECT_LE(jump.is_seen, is_near);
  }
  EXPECT_GE(std::count_if(jumping.jumps.begin(), jumping.jumps.end(), [](const Jump& j) { return j.is_seen; }), 4);
}

TEST(Jumps, FollowFromTheSeed) {
  const std::vector<Pose> path = round_a_table();
  const JumpingPath a = with_jumps(path, 4, 1);
  const JumpingPath b = with_jumps(path, 4, 1);
  const JumpingPath c = with_jumps(path, 4, 2);
  for (std::size_t i = 0; i < kFrames; ++i) ASSERT_EQ(a.poses[i].matrix(), b.poses[i].matrix());
  EXPECT_NE(a.jumps[0].to.matrix(), c.jumps[0].to.matrix());
  const JumpingPath none = with_jumps(path, 0, 1);
  EXPECT_EQ(none.poses[99].matrix(), path[99].matrix());
  EXPECT_TRUE(none.jumps.empty());
}

TEST(Jumps, ThatDoNotFitAreRefused) {
  const std::vector<Pose> path = round_a_table();
  const auto message = [&](int jumps) { return test::error_of([&] { with_jumps(path, jumps, 1); }); };
  EXPECT_THAT(message(7), HasSubstr("jumps = 7 do not fit 600 frames: one takes 90 frames; ask for 0 to 6"));
  EXPECT_THAT(message(-1), HasSubstr("jumps = -1"));
  EXPECT_EQ(with_jumps(path, 6, 1).jumps.size(), 6U);
  const SimulationOptions busy{.seed = 3, .rooms = 1, .frames = 200, .dynamics = "people", .jumps = 1};
  EXPECT_THAT(test::error_of([&] { const Simulation simulation(busy); }), HasSubstr("do not go with dynamics 'people'"));
}

TEST(Jumps, AreReadFromTextAndShownBySimulation) {
  EXPECT_EQ(parse_simulation("sim:3,jumps=2").jumps, 2);
  EXPECT_THAT(test::error_of([] { parse_simulation("sim:3,jumps=often"); }), HasSubstr("sim:SEED"));
  const Simulation simulation({.seed = 3, .rooms = 1, .frames = 200, .jumps = 2});
  EXPECT_THAT(simulation.description(), HasSubstr("carried off 2 times"));
  ASSERT_EQ(simulation.jumps().jumps.size(), 2U);
  const Jump& jump = simulation.jumps().jumps[0];
  EXPECT_EQ(simulation.simulate(jump.frame).true_world_from_camera.matrix(), jump.to.matrix());
}

TEST(Jumps, AreWrittenAsTruth) {
  const std::filesystem::path file = test::fresh_folder("jumps") / kJumpsFile;
  const JumpingPath jumping = with_jumps(round_a_table(), 2, 5);
  write_jumps(file, jumping, 30);
  const Json json = read_json_file(file);
  EXPECT_EQ(json["frames"], kFrames);
  ASSERT_EQ(json["jumps"].size(), 2U);
  EXPECT_EQ(json["jumps"][1]["frame"], jumping.jumps[1].frame);
  EXPECT_EQ(json["jumps"][1]["seen_before"], jumping.jumps[1].is_seen);
  EXPECT_EQ(json["jumps"][1]["to"][0][3], jumping.jumps[1].to.translation().x());
  EXPECT_EQ(json["jumps"][1]["from"].size(), 4U);
}

}  // namespace
}  // namespace panoptic
