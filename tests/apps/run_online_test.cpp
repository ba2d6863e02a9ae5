// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run --online` and `--view` from outside.
#include <signal.h>
#include <unistd.h>

#include "panoptic/base/files.h"
#include "panoptic/outputs.h"
#include "tests/apps/run_fixture.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::ProgramResult;
using test::Run;
using test::run_program;
using test::RunningProgram;
using testing::HasSubstr;

class RunOnline : public Run {};

TEST_F(RunOnline, AtFullSpeedMapsEveryFrameAndReportsRatesAndLatencies) {
  const ProgramResult result = run({"--predictions", write_predictions().string(), "--online", "--speed", "max"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json report = this->report();
  EXPECT_EQ(report["complete"], true);
  const Json& online = report["online"];
  EXPECT_EQ(online["read"], 12);
  EXPECT_EQ(online["used"], 12);
  EXPECT_EQ(online["dropped"], 0);
  EXPECT_EQ(online["lost"], 0);
  EXPECT_GE(online["labelled"].get<int>(), 1);
  EXPECT_EQ(online["labelled"].get<int>() + online["passed_over"].get<int>(), 12);
  EXPECT_GT(online["geometry_hz"].get<double>(), 0);
  for (const char* until : {"fused", "labelled", "visible"}) {
    EXPECT_GT(online["latency"].at(until)["p95_ms"].get<double>(), 0) << until;
  }
  EXPECT_EQ(online["latency"]["visible"]["count"], 12);
  EXPECT_EQ(report["stages"]["predict"]["count"], online["labelled"]);
  EXPECT_THAT(result.out, HasSubstr("read to visible"));
  const Mesh online_mesh = read_ply(out_ / "mesh.ply");

  ASSERT_EQ(run({"--predictions", write_predictions().string()}).exit_code, 0);
  const Mesh offline_mesh = read_ply(out_ / "mesh.ply");
  ASSERT_EQ(online_mesh.vertices.size(), offline_mesh.vertices.size());
  for (std::size_t i = 0; i < online_mesh.vertices.size(); ++i) {
    ASSERT_EQ(online_mesh.vertices[i].position, offline_mesh.vertices[i].position) << "the same surface";
    ASSERT_EQ(online_mesh.vertices[i].color, offline_mesh.vertices[i].color);
  }
  EXPECT_FALSE(this->report().contains("online"));
}

TEST_F(RunOnline, SpeedNeedsOnlineAndANumber) {
  EXPECT_EQ(run({"--speed", "2"}).exit_code, 2);
  EXPECT_EQ(run({"--online", "--speed", "fast"}).exit_code, 2);
  EXPECT_EQ(run({"--online", "--speed", "-1"}).exit_code, 2);
}

TEST_F(RunOnline, InterruptedItWritesTheFinalStateOfWhatWasRead) {
  const ProgramResult result = run_program({"run", "--no-pictures", recording_.string(), "-o", out_.string(), "--predictions",
                                            write_predictions().string(), kCoarse[0], kCoarse[1], "--online", "--speed", "0.1"},
                                           {}, [](const RunningProgram& program) {
                                             test::wait_for_text(program, program.out, "labels");
                                             usleep(700000);
                                             kill(program.pid, SIGINT);
                                           });
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_THAT(result.err, HasSubstr("interrupted: the map so far is in"));
  const Json report = this->report();
  EXPECT_EQ(report["complete"], false);
  EXPECT_EQ(report["stopped_by"], "interrupted");
  EXPECT_GE(report["online"]["used"].get<int>(), 1);
  EXPECT_LT(report["online"]["used"].get<int>(), 12);
  EXPECT_EQ(report["online"]["lost"], 0);
  EXPECT_FALSE(read_ply(out_ / "mesh.ply").vertices.empty());
}

TEST_F(RunOnline, ADamagedPredictionEndsTheRunInOneLineWithTheMapSoFar) {
  const std::filesystem::path predictions = write_predictions();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(predictions)) {
    if (entry.path().extension() == ".png" && entry.path().stem() >= "000006") std::filesystem::resize_file(entry.path(), 20);
  }
  // Slow, so that a second passes between the first frame and the first damaged prediction: there is a map to be kept.
  const ProgramResult result = run({"--predictions", predictions.string(), "--online", "--speed", "0.2"});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "marked incomplete");
  const Json report = this->report();
  EXPECT_EQ(report["complete"], false);
  EXPECT_EQ(report["online"]["read"], report["online"]["used"].get<int>() + report["online"]["lost"].get<int>());
}

TEST_F(RunOnline, LookingOnChangesNothing) {
  const std::string predictions = write_predictions().string();
  ASSERT_EQ(run({"--predictions", predictions}).exit_code, 0);
  const std::string hash = report()["map_hash"];
  const std::string mesh = read_file(out_ / "mesh.ply");
  const ProgramResult result = run({"--predictions", predictions, "--view", "--port", "0"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("look at   http://127.0.0.1:"));
  EXPECT_EQ(report()["map_hash"], hash);
  EXPECT_EQ(read_file(out_ / "mesh.ply"), mesh);
}

}  // namespace
}  // namespace panoptic
