// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "panoptic/parallel.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using testing::HasSubstr;

SimulationOptions small(const std::string& noise = "kinect") { return {.seed = 3, .rooms = 1, .frames = 40, .noise = noise}; }

// Shared by the tests that only look.
const Simulation& home() {
  static const Simulation kSimulation(small());
  return kSimulation;
}

TEST(Simulation, GivesAsManyFramesAsAskedForWithCameraAndTime) {
  ASSERT_EQ(home().size(), 40U);
  const ReadResult result = home().read(17);
  ASSERT_TRUE(result.frame.has_value());
  const Frame& frame = *result.frame;
  EXPECT_EQ(frame.index, 17);
  EXPECT_DOUBLE_EQ(frame.time_s, 17 / 30.0);
  EXPECT_EQ(frame.depth_camera, (Camera{640, 480, 577.87, 577.87, 319.5, 239.5}));
  EXPECT_EQ(frame.color_camera, frame.depth_camera);
  EXPECT_TRUE(frame.depth.same_size(640, 480));
  EXPECT_TRUE(frame.color.same_size(640, 480));
  EXPECT_TRUE(is_rigid(frame.world_from_camera, 1e-6));
}

TEST(Simulation, EveryFrameCanBeUsedAndSeesThings) {
  std::set<std::uint16_t> things;
  for (std::size_t i = 0; i < home().size(); i += 5) {
    const SimulatedFrame frame = home().simulate(i);
    EXPECT_TRUE(check(frame.frame).used);
    for (const std::uint16_t instance : frame.rendering.instance.pixels()) things.insert(instance);
  }
  EXPECT_GT(things.size(), 8U);
}

TEST(Simulation, AnyOrderAndAnyThreadGiveTheSameFrames) {
  std::vector<SimulatedFrame> forwards;
  for (const std::size_t position : {0, 13, 26}) forwards.push_back(home().simulate(position));
  set_thread_count(1);
  const Simulation again(small());
  std::vector<SimulatedFrame> backwards(3);
  {
    std::vector<std::thread> threads;
    for (int i = 2; i >= 0; --i)
      threads.emplace_back([&, i] { backwards[i] = again.simulate(static_cast<std::size_t>(13 * i)); });
    for (std::thread& thread : threads) thread.join();
  }
  set_thread_count(0);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(forwards[i].frame.depth == backwards[i].frame.depth);
    EXPECT_TRUE(forwards[i].frame.color == backwards[i].frame.color);
    EXPECT_TRUE(forwards[i].rendering.instance == backwards[i].rendering.instance);
    EXPECT_EQ(forwards[i].frame.world_from_camera.matrix(), backwards[i].frame.world_from_camera.matrix());
  }
}

TEST(Simulation, NoiseLeavesTheTruthAlone) {
  const Simulation harsh(small("harsh"));
  const SimulatedFrame a = home().simulate(30);
  const SimulatedFrame b = harsh.simulate(30);
  EXPECT_TRUE(a.rendering.depth == b.rendering.depth);
  EXPECT_TRUE(a.rendering.color == b.rendering.color);
  EXPECT_EQ(a.true_world_from_camera.matrix(), b.true_world_from_camera.matrix());
  EXPECT_FALSE(a.frame.depth == a.rendering.depth);
  EXPECT_TRUE(a.frame.color == a.rendering.color) << "the kinect's noise is that of its depth";
  EXPECT_EQ(a.frame.world_from_camera.matrix(), a.true_world_from_camera.matrix());
  EXPECT_FALSE(b.frame.color == b.rendering.color);
  const double drift_m = (b.frame.world_from_camera.translation() - b.true_world_from_camera.translation()).norm();
  EXPECT_GT(drift_m, 1e-4);
  EXPECT_LT(drift_m, 0.1);
}

TEST(Simulation, DescribesItself) {
  EXPECT_THAT(home().description(), HasSubstr("simulated home 3: 1 room, "));
  EXPECT_THAT(home().description(), HasSubstr("40 frames, depth and colour 640x480, noise 'kinect'"));
}

TEST(Simulation, RefusesOptionsOutOfRange) {
  const auto message = [](SimulationOptions options) { return test::error_of([&] { const Simulation simulation(options); }); };
  EXPECT_THAT(message({.frames = -1}), HasSubstr("frames = -1"));
  EXPECT_THAT(message({.frames = 2'000'000'000}), HasSubstr("out of range"));
  EXPECT_THAT(message({.noise = "loud"}), HasSubstr("'loud'"));
  EXPECT_THAT(message({.rooms = 0}), HasSubstr("rooms"));
  EXPECT_THAT(message({.rooms = 1000}), HasSubstr("rooms"));
}

TEST(SimulationOptions, AreReadFromText) {
  EXPECT_EQ(parse_simulation("sim:7").seed, 7U);
  EXPECT_EQ(parse_simulation("sim:18446744073709551615").seed, UINT64_MAX);
  const SimulationOptions options = parse_simulation("sim:12,rooms=2,frames=300,noise=none");
  EXPECT_EQ(options.seed, 12U);
  EXPECT_EQ(options.rooms, 2);
  EXPECT_EQ(options.frames, 300);
  EXPECT_EQ(options.noise, "none");
}

TEST(SimulationOptions, BadTextIsRefusedShowingTheSyntax) {
  for (const char* text :
       {"", "sim", "sim:", "sim:x", "sim:-1", "sim:18446744073709551616", "sim:1x", "sim:1,", "sim:1,rooms",
        "sim:1,rooms=", "sim:1,rooms=2.5", "sim:1,frames=99999999999", "sim:1,walls=3", "sim:1,,rooms=2", "home:1"}) {
    EXPECT_THAT(test::error_of([&] { parse_simulation(text); }), HasSubstr("sim:SEED")) << text;
  }
  EXPECT_THAT(test::error_of([] { parse_simulation("sim:1,noise=loud"); }), HasSubstr("kinect"));
}

}  // namespace
}  // namespace panoptic
