// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The parts that need no Slurm; tests/tools/batch_slurm_test.py has a real one.
#include "panoptic/batch/slurm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/child_process.h"
#include "panoptic/base/files.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

TEST(Slurm, KeepsBelowTheLargestArrayOfTheSite) {
  EXPECT_EQ(max_array_size("LogFile = x\nMaxArraySize            = 1001\nMaxJobCount = 10000\n"), 1000U);
  EXPECT_THROW(max_array_size("MaxArraySize            = 0\n"), Error);
  EXPECT_THROW(max_array_size("MaxJobCount = 10\n"), Error);
}

TEST(Slurm, TheGatheringTakesOverWhereItRunsAndWhoPays) {
  const std::vector<std::string> options{"--mem=16G", "--partition=gpu", "-A", "us", "-qlong", "--gres=gpu:1"};
  EXPECT_EQ(gathering_options(options), (std::vector<std::string>{"--partition=gpu", "-A", "us", "-qlong"}));
}

TEST(Slurm, WordsComeThroughAShellAsTheyAre) {
  const std::filesystem::path log = test::fresh_folder() / "log.txt";
  const std::vector<std::string> words{"printf", "<%s>\\n", "it's", "a b", "", "$HOME", "\\", "`x`", "*", "\"q\""};
  ASSERT_EQ(wait_for_child(start_child({"sh", "-c", shell_line(words)}, log)).exit_code, 0);
  EXPECT_EQ(read_file(log), "<it's>\n<a b>\n<>\n<$HOME>\n<\\>\n<`x`>\n<*>\n<\"q\">\n");
}

}  // namespace
}  // namespace panoptic
