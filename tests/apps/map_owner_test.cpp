// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map file has one owner: who writes it keeps all other writers out, and nobody who reads.
#include <unistd.h>

#include <csignal>

#include "panoptic/base/files.h"
#include "panoptic/map_file.h"
#include "tests/apps/run_fixture.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::ProgramResult;
using test::run_program;
namespace fs = std::filesystem;

class MapOwner : public test::Run {
 protected:
  std::vector<std::string> run_arguments(const fs::path& out, std::vector<std::string> more = {}) const {
    std::vector<std::string> all{"run",         "--no-pictures", recording_.string(),     "-o",        out.string(), "--map",
                                 map_.string(), "--set",         "map.voxel_size_m=0.08", "--threads", "1"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  fs::path map_ = fresh_folder("map") / "map.panoptic";
};

TEST_F(MapOwner, IsTheRunAsLongAsItIsAlive) {
  std::vector<std::string> slow = run_arguments(out_, {"--online", "--speed", "0.01"});  // alive until it is told to stop
  const ProgramResult owner = run_program(slow, {}, [&](const test::RunningProgram& program) {
    ASSERT_TRUE(test::wait_for_text(program, program.out, "labels"));
    while (!fs::exists(map_)) usleep(5000);
    const fs::path elsewhere = fresh_folder("elsewhere");
    for (const auto& writer : {std::vector<std::string>{"regularize", map_.string()}, run_arguments(elsewhere, {"--resume"})}) {
      const ProgramResult refused = run_program(writer);
      EXPECT_EQ(refused.exit_code, 1) << writer.front();
      expect_one_line(refused.err, "another run writes");
    }
    const ProgramResult anew = run_program(run_arguments(elsewhere));
    EXPECT_EQ(anew.exit_code, 1);
    expect_one_line(anew.err, "is there already");
    EXPECT_TRUE(fs::is_empty(elsewhere)) << "before it writes anything";
    const ProgramResult merge = run_program({"merge", map_.string(), map_.string(), "-o", map_.string()});
    EXPECT_EQ(merge.exit_code, 1);
    expect_one_line(merge.err, "is there already");
    EXPECT_EQ(run_program({"query", map_.string()}).exit_code, 0) << "whoever reads may";
    EXPECT_EQ(run_program({"info", map_.string()}).exit_code, 0);
    kill(program.pid, SIGINT);
  });
  EXPECT_EQ(owner.exit_code, 130) << owner.err;
  EXPECT_EQ(fmt::format("{:016x}", load_map(map_).map.voxels.hash()), report()["map_hash"]) << "unharmed";
  EXPECT_EQ(run_program({"regularize", map_.string()}).exit_code, 0) << "free again";
}

TEST_F(MapOwner, ThatWasKilledLeavesTheFileFree) {
  const ProgramResult killed =
      run_program(run_arguments(out_, {"--checkpoint-every", "0"}), {}, [&](const test::RunningProgram& program) {
        test::wait_for_text(program, program.out, "labels");
        while (!fs::exists(map_) && ::kill(program.pid, 0) == 0) usleep(1000);
        kill(program.pid, SIGKILL);
      });
  ASSERT_EQ(killed.exit_code, 128 + SIGKILL) << killed.err;
  const ProgramResult resumed = run_program(run_arguments(out_, {"--resume"}));
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
}

TEST_F(MapOwner, IsOneOfEightThatStartAtOnce) {
  for (int round = 0; round < 3; ++round) {
    fs::remove_all(map_.parent_path());
    fs::create_directories(map_.parent_path());
    std::vector<std::vector<std::string>> programs;
    std::vector<fs::path> outs;
    for (int i = 0; i < 8; ++i) {
      outs.push_back(fresh_folder(fmt::format("out_{}", i)));
      programs.push_back(run_arguments(outs.back(), {"--frames", "0:2"}));
    }
    int winners = 0;
    const std::vector<ProgramResult> results = test::run_at_once(programs);
    for (std::size_t i = 0; i < results.size(); ++i) {
      if (results[i].exit_code == 0) {
        ++winners;
        continue;
      }
      EXPECT_EQ(results[i].exit_code, 1) << results[i].err;
      expect_one_line(results[i].err, "map.panoptic");
      EXPECT_TRUE(fs::is_empty(outs[i])) << "refused before it wrote anything";
    }
    EXPECT_EQ(winners, 1);
    EXPECT_EQ(load_frames(map_).size(), 2U);
    EXPECT_EQ(std::distance(fs::directory_iterator(map_.parent_path()), fs::directory_iterator()), 1) << "nothing beside it";
  }
}

}  // namespace
}  // namespace panoptic
