// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Recordings without poses, and eval-trajectory, from outside.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "tests/apps/program.h"
#include "tests/apps/run_fixture.h"
#include "tests/apps/tracked_room.h"
#include "tests/shared_data.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;
namespace fs = std::filesystem;

using test::kWayRound;

constexpr int kFrames = 12;

class Track : public test::TrackedRoom {
 protected:
  Track() : recording_(recording("room", 0, kFrames)) {}

  void write_pose(int n) const {
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> m = test::room_pose(n, kWayRound).matrix();
    write_file(recording_ / fmt::format("frame-{:06}.pose.txt", n), fmt::format("{}\n", fmt::join(m.data(), m.data() + 16, " ")));
  }
  ProgramResult run(const std::vector<std::string>& more = {}) const { return run_over(recording_, more); }

  const fs::path recording_;
};

TEST_F(Track, ARecordingWithoutPosesIsTracked) {
  const ProgramResult result = run();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("poses     none: the camera is tracked"));
  EXPECT_THAT(result.out, HasSubstr("tracking  12 frames, 0 lost"));
  const Json tracking = report()["tracking"];
  EXPECT_EQ(tracking["tracked"], kFrames);
  EXPECT_EQ(tracking["spans"].size(), 2U);
  EXPECT_TRUE(is_file(out_ / "loops.json"));
  EXPECT_FALSE(is_file(out_ / "given_trajectory.txt"));
}

TEST_F(Track, OnlineItIsTrackedTheSameWay) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string offline = read_file(out_ / "trajectory.txt");
  const ProgramResult result = run({"--online", "--speed", "max"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("poses     none: the camera is tracked"));
  EXPECT_EQ(report()["tracking"]["tracked"], kFrames);
  EXPECT_EQ(report()["online"]["used"], kFrames);
  EXPECT_EQ(read_file(out_ / "trajectory.txt"), offline) << "where nothing is dropped";
  EXPECT_TRUE(is_file(out_ / "loops.json"));
}

TEST_F(Track, OnlineThroughASimulatedHome) {
  const fs::path out = folder_ / "home";
  const ProgramResult result = run_program({"run", "sim:3,rooms=1,noise=none", "--frames", ":40", "--online", "--speed", "max",
                                            "--track", "--no-pictures", "--set", "map.voxel_size_m=0.04", "-o", out.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const fs::path scores = folder_ / "scores.json";
  const ProgramResult scored =
      run_program({"eval-trajectory", out.string(), (out / "given_trajectory.txt").string(), "--json", scores.string()});
  ASSERT_EQ(scored.exit_code, 0) << scored.err;
  const Json json = Json::parse(read_file(scores));
  EXPECT_GE(json["share_of_truth"].get<double>(), 0.95);
  EXPECT_LT(json["ate_m"]["rmse"].get<double>(), 0.02);
}

// The camera comes back to a place of the kitchen, and the map follows.
TEST_F(Track, SlowlyLoopsAreFollowedOnlineAsOffline) {
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  const auto tracked = [&](std::vector<std::string> more) {
    more.insert(more.end(),
                {"--track", "--frames", ":300", "--calibration", (test::source_folder() / "configs/kitchen.toml").string()});
    const ProgramResult result = run_over(test::shared_folder() / "data/kitchen", more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_file(out_ / "trajectory.txt");
  };
  const std::string offline = tracked({});
  const Json before = report()["corrections"];
  ASSERT_GE(before.size(), 1U);
  EXPECT_EQ(tracked({"--online", "--speed", "max"}), offline);
  const Json corrections = report()["corrections"];
  ASSERT_EQ(corrections.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(corrections[i]["frames"], before[i]["frames"]);
    EXPECT_LT(corrections[i]["pause_ms"].get<double>(), 50);
  }
}

TEST_F(Track, ATrackedMapIsNotResumedButFollowsPosesFromOutside) {
  const fs::path map = folder_ / "map.panoptic";
  ASSERT_EQ(run({"--map", map.string(), "--frames", "0:8"}).exit_code, 0);
  for (int n = 0; n < kFrames; ++n) write_pose(n);
  expect_one_line(run({"--map", map.string(), "--frames", "0:8", "--resume"}).err, "tracked the camera");
  for (int n = 0; n < kFrames; ++n) fs::remove(recording_ / fmt::format("frame-{:06}.pose.txt", n));
  const ProgramResult rebuilt = run_program(
      {"rebuild", map.string(), "--poses", (out_ / "trajectory.txt").string(), "-o", (folder_ / "new.panoptic").string()});
  EXPECT_EQ(rebuilt.exit_code, 0) << rebuilt.err;
}

TEST_F(Track, GivenPosesAreNotUsedButCompared) {
  for (int n = 0; n < kFrames; ++n) write_pose(n);
  ASSERT_EQ(run({"--track"}).exit_code, 0);
  const ProgramResult scores = run_program(
      {"eval-trajectory", out_.string(), (out_ / "given_trajectory.txt").string(), "--json", (folder_ / "scores.json").string()});
  ASSERT_EQ(scores.exit_code, 0) << scores.err;
  EXPECT_THAT(scores.out, HasSubstr("12 pairs: 100.0 % of the 12 estimated poses, 100.0 % of the 12 true ones"));
  const Json json = Json::parse(read_file(folder_ / "scores.json"));
  EXPECT_LT(json["ate_m"]["rmse"].get<double>(), 0.01);
  EXPECT_EQ(json["share_of_truth"], 1.0);
  EXPECT_TRUE(json["rpe_m"].is_null());  // 12 frames are less than a second
  // Another run into the same folder leaves nothing of the tracked one.
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_FALSE(is_file(out_ / "loops.json"));
  EXPECT_FALSE(report().contains("tracking"));
}

TEST_F(Track, WhatCannotBeTrackedIsRefusedInOneLine) {
  const auto refuse = [&](const std::vector<std::string>& more, int code, const char* part) {
    const ProgramResult result = run(more);
    EXPECT_EQ(result.exit_code, code);
    expect_one_line(result.err, part);
  };
  refuse({"--track", "--resume", "--map", (folder_ / "m.panoptic").string()}, 2, "--track does not go with --resume");
  refuse({"--set", "map.log=none"}, 2, "needs the log for it");
  for (int n = 0; n < kFrames; ++n) {  // nothing to begin with
    write_png(recording_ / fmt::format("frame-{:06}.depth.png", n), Image<std::uint16_t>(320, 240, std::uint16_t{0}));
  }
  const ProgramResult blind = run();
  EXPECT_EQ(blind.exit_code, 1);
  EXPECT_THAT(blind.err, HasSubstr("no frame was usable"));
}

TEST_F(Track, TrajectoriesThatCannotBeComparedAreRefused) {
  write_file(folder_ / "a.txt", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 1 1 0 0 0 0 1\n");
  write_file(folder_ / "b.txt", "100 0 0 0 0 0 0 1\n101 1 0 0 0 0 0 1\n102 1 1 0 0 0 0 1\n");
  const auto compare = [&](const char* a, const char* b) {
    return run_program({"eval-trajectory", (folder_ / a).string(), (folder_ / b).string()});
  };
  expect_one_line(compare("a.txt", "b.txt").err, "are the time stamps of one clock?");
  expect_one_line(compare("a.txt", "absent.txt").err, "absent.txt");
  expect_one_line(compare("room", "b.txt").err, "holds neither trajectory.txt nor groundtruth.txt");
  EXPECT_EQ(compare("a.txt", "a.txt").exit_code, 0);
}

}  // namespace
}  // namespace panoptic
