// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "tests/apps/program.h"
#include "tests/apps/run_fixture.h"
#include "tests/fresh_folder.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::vector<std::string> simulate(const fs::path& out, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments{"simulate", "--seed", "4", "--rooms", "1", "--frames", "4", "-o", out.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(Simulate, MakesAScanThatRunAndDoctorTake) {
  const fs::path home = fresh_folder("homes") / "home";
  std::vector<std::string> arguments = simulate(home, {"--set", "truth_stride=10"});
  arguments[6] = "30";  // so many that neighbours see the same: the doctor compares them
  const ProgramResult made = run_program(arguments);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, AllOf(HasSubstr("1 rooms"), HasSubstr(" m2"), HasSubstr("30 frames in"), HasSubstr("frames/s")));
  EXPECT_THAT(made.out, HasSubstr("panoptic run " + home.string() + " --predictions " + (home / "predictions").string()));

  const ProgramResult checked = run_program({"doctor", home.string()});
  EXPECT_EQ(checked.exit_code, 0) << checked.out;

  const fs::path out = fresh_folder("out");
  const ProgramResult mapped =
      run_program({"run", "--no-pictures", home.string(), "--predictions", (home / "predictions").string(), "-o", out.string(),
                   "--set", "map.voxel_size_m=0.08", "--frames", "0:30:3"});
  ASSERT_EQ(mapped.exit_code, 0) << mapped.err;
  EXPECT_THAT(mapped.out, HasSubstr("10 frames used, 0 skipped"));
  EXPECT_GT(read_json_file(out / "objects.json").at("objects").size(), 2U);
}

TEST(Simulate, RepeatsAnEarlierSimulation) {
  const fs::path folder = fresh_folder("homes");
  ASSERT_EQ(run_program(simulate(folder / "a", {"--predictions", "poor", "--set", "prediction_noise.missed=0.4"})).exit_code, 0);
  const ProgramResult again =
      run_program({"simulate", "--config", (folder / "a" / "simulation.toml").string(), "-o", folder / "b"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(read_file(folder / "a" / "simulation.toml"), read_file(folder / "b" / "simulation.toml"));
  EXPECT_EQ(read_file(folder / "a" / "scene0004_00.sens"), read_file(folder / "b" / "scene0004_00.sens"));
  EXPECT_EQ(read_file(folder / "a" / "predictions" / "000003.json"), read_file(folder / "b" / "predictions" / "000003.json"));
}

TEST(Simulate, WritesWhereTheCameraWasCarriedOff) {
  const fs::path home = fresh_folder("homes") / "home";
  std::vector<std::string> arguments = simulate(home, {"--jumps", "1", "--predictions", "none"});
  arguments[6] = "100";
  const ProgramResult made = run_program(arguments);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("carried off 1 times"));
  EXPECT_EQ(read_json_file(home / "jumps.json")["jumps"].size(), 1U);
  EXPECT_THAT(read_file(home / "simulation.toml"), HasSubstr("jumps = 1"));
  const ProgramResult many = run_program(simulate(home.string() + "2", {"--jumps", "1"}));
  EXPECT_EQ(many.exit_code, 1);
  expect_one_line(many.err, "jumps = 1 do not fit 4 frames");
  EXPECT_EQ(run_program(simulate(home.string() + "2", {"--jumps", "-1"})).exit_code, 2);
}

TEST(Simulate, RefusesWhatItDoesNotKnow) {
  const fs::path home = fresh_folder("homes") / "home";
  const ProgramResult predictions = run_program(simulate(home, {"--predictions", "best"}));
  EXPECT_EQ(predictions.exit_code, 2);
  expect_one_line(predictions.err, "choose one of oracle, good, maskrcnn, poor");
  const ProgramResult noise = run_program(simulate(home, {"--noise", "loud"}));
  EXPECT_EQ(noise.exit_code, 2);
  expect_one_line(noise.err, "kinect");
  EXPECT_EQ(run_program({"simulate", "--seed", "x", "-o", home}).exit_code, 2);
  EXPECT_EQ(run_program({"simulate", "--seed", "1"}).exit_code, 2);
  EXPECT_EQ(run_program({"simulate", "--rooms", "9", "-o", home}).exit_code, 2);
  EXPECT_FALSE(fs::exists(home));
}

TEST(Simulate, DoesNotOverwrite) {
  const fs::path home = fresh_folder("homes");
  write_file(home / "notes.txt", "mine");
  const ProgramResult result = run_program(simulate(home));
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "already holds something");
  EXPECT_EQ(read_file(home / "notes.txt"), "mine");
}

TEST(Simulate, LeavesNothingWhenInterrupted) {
  const fs::path folder = fresh_folder("homes");
  const fs::path home = folder / "home";
  std::vector<std::string> arguments = simulate(home);
  arguments[6] = "2000";
  const ProgramResult result = run_program(arguments, {}, [&](const RunningProgram& program) {
    const fs::path growing = home.string() + ".partial/predictions/predictions.json";
    EXPECT_TRUE(wait_for_text(program, growing, "scannet20"));
    kill(program.pid, SIGINT);
  });
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_THAT(result.err, HasSubstr("interrupted: nothing is left in"));
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(Simulate, SaysThatTheDiskIsFullAndLeavesNothing) {
  const fs::path folder = fresh_folder("homes");
  const ProgramResult result = run_program(simulate(folder / "home"), [] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{300000, 300000};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "cannot write");
  EXPECT_TRUE(fs::is_empty(folder));
}

}  // namespace
}  // namespace panoptic::test
