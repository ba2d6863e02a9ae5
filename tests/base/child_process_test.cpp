// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/child_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "panoptic/base/files.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::fresh_folder;
namespace fs = std::filesystem;

TEST(ChildProcess, AddsWhatItPrintsToTheLogAndTellsItsExitCode) {
  const fs::path log = fresh_folder() / "log.txt";
  write_file(log, "before\n");
  const EndedChild ended = wait_for_child(start_child({"sh", "-c", "echo out; echo err >&2; read line; exit 7"}, log));
  EXPECT_EQ(ended.exit_code, 7);
  EXPECT_GT(ended.peak_mb, 0.1);
  EXPECT_LT(ended.peak_mb, 2000);
  EXPECT_EQ(read_file(log), "before\nout\nerr\n");
}

TEST(ChildProcess, TellsTheSignalThatEndedIt) {
  const int child = start_child({"sleep", "1000"}, fresh_folder() / "log.txt");
  EXPECT_FALSE(ended_child(child));
  kill_child(child);
  EXPECT_EQ(wait_for_child(child).exit_code, 128 + SIGKILL);
}

TEST(ChildProcess, ThatCannotBeStartedIsAnErrorThatNamesIt) {
  try {
    start_child({"no-such-program"}, fresh_folder() / "log.txt");
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("cannot start no-such-program: No such file"));
  }
  EXPECT_THROW(start_child({"true"}, fresh_folder() / "absent" / "log.txt"), FileError);
}

// Ends as if it had been killed, with a child that would live on.
[[noreturn]] void leave_a_child(const fs::path& folder) {
  const FolderClaim claim(folder / "lock", FolderClaim::Kind::kAlone);
  write_file(folder / "number", std::to_string(start_child({"sleep", "1000"}, folder / "log.txt")));
  ::kill(::getpid(), SIGKILL);
  ::_exit(1);
}

TEST(ChildProcess, DiesWithItsParentAndHoldsItsClaimUntilThen) {
  const fs::path folder = fresh_folder();
  const pid_t parent = ::fork();
  if (parent == 0) leave_a_child(folder);
  ::waitpid(parent, nullptr, 0);
  const int orphan = std::stoi(read_file(folder / "number"));
  constexpr int kMostTries = 2000;
  int tries = 0;
  while (!FolderClaim(folder / "lock", FolderClaim::Kind::kAlone).is_ours() && tries < kMostTries) {
    ++tries;
    ::usleep(5000);
  }
  EXPECT_LT(tries, kMostTries);
  // A program lets go of its files a moment before it is gone.
  const auto is_gone = [&] {
    return ::kill(orphan, 0) != 0 || read_file("/proc/" + std::to_string(orphan) + "/stat").find(") Z") != std::string::npos;
  };
  while (!is_gone() && tries++ < kMostTries) ::usleep(5000);
  EXPECT_TRUE(is_gone()) << "a claim is free when all who might write are gone";
}

TEST(FolderClaim, IsOneOwnersOrManysShare) {
  const fs::path lock = fresh_folder() / "lock";
  {
    const FolderClaim owner(lock, FolderClaim::Kind::kAlone);
    EXPECT_TRUE(owner.is_ours());
    EXPECT_FALSE(FolderClaim(lock, FolderClaim::Kind::kAlone).is_ours());
    EXPECT_FALSE(FolderClaim(lock, FolderClaim::Kind::kShared).is_ours());
  }
  const FolderClaim one(lock, FolderClaim::Kind::kShared);
  EXPECT_TRUE(one.is_ours());
  EXPECT_TRUE(FolderClaim(lock, FolderClaim::Kind::kShared).is_ours());
  EXPECT_FALSE(FolderClaim(lock, FolderClaim::Kind::kAlone).is_ours());
}

}  // namespace
}  // namespace panoptic
