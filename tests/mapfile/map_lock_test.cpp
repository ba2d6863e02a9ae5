// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/map_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/error.h"
#include "panoptic/map_file.h"
#include "panoptic/mapfile/map_writer.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::HasSubstr;

MapHeader header() { return {MapOptions{}, LabelSet("none", {{ClassId{1}, "wall", false, {}}})}; }

// Runs the action in a process of its own; returns its exit code.
int in_child(const std::function<int()>& action) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(action());
  int status = -1;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int try_lock(const std::filesystem::path& path) {
  try {
    const MapLock lock(path);
    return 0;
  } catch (const Error&) {
    return 1;
  }
}

TEST(MapLock, IsHeldByOneAtATimeInThisProcessAndInOthers) {
  const auto path = fresh_folder() / "map.panoptic";
  write_file(path, "some");
  {
    std::optional<MapLock> first(path);
    EXPECT_THAT(error_of([&] { MapLock second(path); }), HasSubstr("another run writes"));
    EXPECT_EQ(in_child([&] { return try_lock(path); }), 1);
    MapLock moved(std::move(*first));
    first.reset();
    EXPECT_EQ(in_child([&] { return try_lock(path); }), 1) << "what was moved from holds nothing";
  }
  EXPECT_EQ(in_child([&] { return try_lock(path); }), 0);
  EXPECT_EQ(try_lock(path), 0);
}

TEST(MapLock, StaysWithTheFileWhenItIsRenamed) {
  const auto folder = fresh_folder();
  write_file(folder / "a", "some");
  const MapLock lock(folder / "a");
  rename_file(folder / "a", folder / "b");
  EXPECT_EQ(in_child([&] { return try_lock(folder / "b"); }), 1);
  write_file(folder / "a", "another");
  EXPECT_EQ(in_child([&] { return try_lock(folder / "a"); }), 0);
}

TEST(MapLock, OfAKilledProcessIsHeldByNobody) {
  const auto path = fresh_folder() / "map.panoptic";
  write_file(path, "some");
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const MapLock lock(path);
    [[maybe_unused]] const auto written = ::write(ready[1], "x", 1);
    for (;;) ::pause();
  }
  char byte = 0;
  ASSERT_EQ(::read(ready[0], &byte, 1), 1);
  EXPECT_EQ(try_lock(path), 1);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(try_lock(path), 0);
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST(MapLock, OfNoFileIsAnErrorThatNamesThePath) {
  const auto path = fresh_folder() / "absent.panoptic";
  EXPECT_THAT(error_of([&] { MapLock lock(path); }), testing::AllOf(HasSubstr("absent.panoptic"), HasSubstr("No such file")));
}

// The lock on a file is one on what has its name now: a map that is replaced again and again always has one owner.
TEST(MapLock, IsNotFooledByAFileThatIsReplacedMeanwhile) {
  const auto path = fresh_folder() / "map.panoptic";
  save_map(path, header(), {.epoch = 1});
  const pid_t child = ::fork();
  if (child == 0) {
    for (;;) {
      try {
        save_map(path, header(), {.epoch = 1});
      } catch (const Error&) {  // the parent holds it
      }
    }
  }
  constexpr int kTimes = 50;
  const auto deadline =
      std::chrono::steady_clock::now() + std::chrono::minutes(2);  // the child is as fast as the machine lets it
  int held = 0;
  while (held < kTimes && std::chrono::steady_clock::now() < deadline) {
    try {
      const MapLock lock(path);
      const auto before = std::filesystem::last_write_time(path);
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      EXPECT_EQ(std::filesystem::last_write_time(path), before) << "replaced while it was held";
      ++held;
    } catch (const Error&) {  // the child holds it
    }
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_EQ(held, kTimes);
  EXPECT_EQ(load_map(path).map.voxels.block_count(), 0U);
}

// SQLite forgets its locks on a file when the process closes any descriptor of it.
TEST(MapLock, ThatIsRefusedLeavesTheWritersLocksAlone) {
  const auto path = fresh_folder() / "map.panoptic";
  save_map(path, header(), {.epoch = 1});
  const MapLock lock(path);
  Database database(path, DatabaseAccess::kWrite);
  Transaction transaction(database);
  EXPECT_EQ(try_lock(path), 1);
  EXPECT_EQ(in_child([&] {
              try {
                Database other(path, DatabaseAccess::kWrite);
                other.execute("PRAGMA busy_timeout = 0; BEGIN IMMEDIATE");
                return 0;
              } catch (const Error&) {
                return 1;
              }
            }),
            1);
}

TEST(MapFile, IsNeverWrittenOverByCreate) {
  const auto path = fresh_folder() / "map.panoptic";
  save_map(path, header(), {.epoch = 7});
  EXPECT_THAT(error_of([&] { MapFileWriter::create(path, header(), {.epoch = 1}); }), HasSubstr("is there already"));
  EXPECT_EQ(load_map(path).map.voxels.epoch(), 7U);
}

TEST(MapFile, OfSeveralWhoCreateItAtOnceOneDoes) {
  for (int round = 0; round < 8; ++round) {
    const auto path = fresh_folder() / "map.panoptic";
    int start[2];
    int done[2];
    int release[2];
    ASSERT_EQ(::pipe(start) + ::pipe(done) + ::pipe(release), 0);
    std::vector<pid_t> children;
    for (int i = 0; i < 8; ++i) {
      children.push_back(::fork());
      if (children.back() != 0) continue;
      char byte = 0;
      [[maybe_unused]] auto moved = ::read(start[0], &byte, 1);
      int result = 0;
      try {
        const MapFileWriter writer = MapFileWriter::create(path, header(), {.epoch = 1});
        result = 1;
        moved = ::write(done[1], &result, 1);
        moved = ::read(release[0], &byte, 1);  // holds it until all have tried
        ::_exit(1);
      } catch (const Error&) {
      }
      moved = ::write(done[1], &result, 1);
      ::_exit(0);
    }
    ASSERT_EQ(::write(start[1], "12345678", 8), 8);
    int winners = 0;
    for (int i = 0; i < 8; ++i) {
      char won = 0;
      ASSERT_EQ(::read(done[0], &won, 1), 1);
      winners += won;
    }
    EXPECT_EQ(winners, 1);
    EXPECT_EQ(load_map(path).map.voxels.block_count(), 0U) << "while it is held";
    ASSERT_EQ(::write(release[1], "x", 1), 1);
    for (const pid_t child : children) ::waitpid(child, nullptr, 0);
    for (const int fd : {start[0], start[1], done[0], done[1], release[0], release[1]}) ::close(fd);
  }
}

}  // namespace
}  // namespace panoptic
