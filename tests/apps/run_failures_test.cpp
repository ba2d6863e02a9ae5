// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run` where the world is bad: nothing is lost, and one line says what happened.
#include <sys/resource.h>

#include <csignal>
#include <functional>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/outputs.h"
#include "tests/apps/run_fixture.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::ProgramResult;
using test::Run;
using test::run_program;
using testing::HasSubstr;
namespace fs = std::filesystem;

TEST_F(Run, BadFramesAreSkippedCountedAndListed) {
  write_file(file(1, "pose.txt"), "nan 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  write_file(file(2, "pose.txt"), "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  write_png(file(3, "depth.png"), Image<std::uint16_t>(160, 120));
  write_png(file(4, "depth.png"), Image<std::uint16_t>(80, 60, 1000));
  fs::remove(file(5, "color.png"));
  fs::resize_file(file(6, "color.png"), 100);
  fs::resize_file(file(7, "depth.png"), 100);
  const ProgramResult result = run();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json frames = report()["frames"];
  EXPECT_EQ(frames["used"], 5);
  EXPECT_EQ(frames["skipped"], 7);
  ASSERT_EQ(frames["skipped_frames"].size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(frames["skipped_frames"][i]["index"], i + 1);
    EXPECT_FALSE(frames["skipped_frames"][i]["reason"].get<std::string>().empty());
  }
  EXPECT_THAT(result.out, HasSubstr("5 frames used, 7 skipped"));
}

TEST_F(Run, ARecordingWithoutAnyUsableFrameStillEndsWithAReport) {
  for (int i = 0; i < 12; ++i) write_png(file(i, "depth.png"), Image<std::uint16_t>(160, 120));
  const ProgramResult result = run();
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "no frame");
  EXPECT_EQ(report()["frames"]["used"], 0);
}

// Acts as a full disk: no file can be longer.
std::function<void()> limit_file_bytes(std::uintmax_t bytes) {
  return [bytes] {
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, SIG_IGN);
  };
}

TEST_F(Run, AFullDiskLosesNothingThatWasThere) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string mesh = read_file(out_ / "mesh.ply");
  const std::string report = read_file(out_ / "report.json");
  const ProgramResult result =
      run_program({"run", "--no-pictures", recording_.string(), "-o", out_.string(), "--set", "map.voxel_size_m=0.03"},
                  limit_file_bytes(20000));
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "mesh.ply");
  EXPECT_TRUE(read_file(out_ / "mesh.ply") == mesh) << "the older file is untouched";
  EXPECT_TRUE(read_file(out_ / "report.json") == report);
  for (const auto& entry : fs::recursive_directory_iterator(out_)) {
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr("partial")));
  }
}

TEST_F(Run, ADiskThatFillsUpMidwayLeavesTheOlderReport) {
  ASSERT_EQ(run_with_pictures({"--set", "map.voxel_size_m=0.2"}).exit_code, 0);
  const auto scene_bytes = std::max(fs::file_size(out_ / "scene.glb"), fs::file_size(out_ / "mesh.ply"));
  const auto view_bytes = fs::file_size(out_ / "views" / "front_color.png");
  ASSERT_LT(scene_bytes, view_bytes) << "so coarse that the pictures are larger than the map";
  ASSERT_EQ(run({"--set", "map.voxel_size_m=0.1"}).exit_code, 0);
  const std::string report = read_file(out_ / "report.json");
  const ProgramResult result = run_program({"run", recording_.string(), "-o", out_.string(), "--set", "map.voxel_size_m=0.2"},
                                           limit_file_bytes((scene_bytes + view_bytes) / 2));
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "front_color.png");
  EXPECT_LE(fs::file_size(out_ / "scene.glb"), scene_bytes) << "written before the disk was full";
  EXPECT_TRUE(read_file(out_ / "report.json") == report) << "no report says that the newer files are complete";
}

TEST_F(Run, CtrlCWritesTheMapSoFarAndMarksItIncomplete) {
  test::write_orbit_recording(recording_, 40);
  const auto interrupt = [](const test::RunningProgram& program) {
    EXPECT_TRUE(test::wait_for_text(program, program.err, "/40 frames"));  // the first is mapped
    kill(program.pid, SIGINT);
  };
  const ProgramResult result =
      run_program({"run", "--no-pictures", recording_.string(), "-o", out_.string(), "--set", "map.voxel_size_m=0.012", "--set",
                   "integrator.method=raycast", "--set", "map.truncation_voxels=20"},
                  {}, interrupt);
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(report()["complete"], false);
  EXPECT_EQ(report()["stopped_by"], "interrupted");
  EXPECT_GT(report()["frames"]["used"], 0);
  EXPECT_LT(report()["frames"]["used"], 40);
  EXPECT_GT(read_ply(out_ / "mesh.ply").vertices.size(), 100U);
}

TEST_F(Run, CtrlCBeforeTheFirstFrameStillEndsOrderly) {
  const auto interrupt = [](const test::RunningProgram& program) {
    EXPECT_TRUE(test::wait_for_text(program, program.out, "labels "));
    kill(program.pid, SIGINT);
  };
  const ProgramResult result = run_program(
      {"run", "--no-pictures", recording_.string(), "-o", out_.string(), "--set", "map.voxel_size_m=0.012"}, {}, interrupt);
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(report()["stopped_by"], "interrupted");
}

TEST_F(Run, RunningOutOfMemoryKeepsTheMapSoFar) {
  if (test::kSanitized)
    GTEST_SKIP() << "the sanitizers take more memory than the limit of this test and never fail an allocation";
  const fs::path predictions = write_predictions();
  fs::resize_file(predictions / "000007.png", 260'000'000);  // of holes, that take no space
  const auto limit_memory = [] {
    const rlimit limit{250'000'000, 250'000'000};
    setrlimit(RLIMIT_DATA, &limit);
  };
  const ProgramResult result = run_program({"run", "--no-pictures", recording_.string(), "-o", out_.string(), "--predictions",
                                            predictions.string(), kCoarse[0], kCoarse[1]},
                                           limit_memory);
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "out of memory; use larger voxels");
  EXPECT_EQ(report()["complete"], false);
  EXPECT_THAT(report()["stopped_by"].get<std::string>(), HasSubstr("out of memory"));
  EXPECT_EQ(report()["frames"]["used"], 7);
  EXPECT_GT(read_ply(out_ / "mesh.ply").vertices.size(), 100U);
}

TEST_F(Run, AFailureOnAFullDiskNamesBoth) {
  const fs::path predictions = write_predictions();
  fs::resize_file(predictions / "000007.png", 60);
  const ProgramResult result = run_program({"run", "--no-pictures", recording_.string(), "-o", out_.string(), "--predictions",
                                            predictions.string(), kCoarse[0], kCoarse[1]},
                                           limit_file_bytes(20000));
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "000007.png");
  expect_one_line(result.err, "mesh.ply");
}

TEST_F(Run, ADamagedPredictionKeepsTheMapSoFar) {
  const fs::path predictions = write_predictions();
  fs::resize_file(predictions / "000007.png", 60);
  const ProgramResult result = run({"--predictions", predictions.string()});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "000007.png");
  EXPECT_EQ(report()["complete"], false);
  EXPECT_EQ(report()["frames"]["used"], 7);
}

}  // namespace
}  // namespace panoptic
