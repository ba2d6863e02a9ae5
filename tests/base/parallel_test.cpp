// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/parallel.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace panoptic {
namespace {

class Parallel : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { set_thread_count(GetParam()); }
  void TearDown() override { set_thread_count(0); }
};

TEST_P(Parallel, CallsEveryIndexOnce) {
  for (const std::size_t count : {0U, 1U, 2U, 7U, 10000U}) {
    std::vector<std::atomic<int>> calls(count);
    parallel_for(count, [&](std::size_t i) { calls[i]++; });
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(calls[i], 1) << i << " of " << count;
  }
}

TEST_P(Parallel, ThrowsWhatABodyThrowsAndWorksAfterwards) {
  try {
    parallel_for(1000, [](std::size_t i) {
      if (i == 500) throw std::runtime_error("from 500");
    });
    ADD_FAILURE() << "the exception is lost";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "from 500");
  }
  std::atomic<int> calls = 0;
  parallel_for(100, [&](std::size_t) { calls++; });
  EXPECT_EQ(calls, 100);
}

TEST_P(Parallel, GivesTheSameResultAsOneThread) {
  const auto run = [] {
    std::vector<double> values(5000);
    parallel_for(values.size(), [&](std::size_t i) { values[i] = std::sin(static_cast<double>(i)) / 3; });
    return values;
  };
  const std::vector<double> several = run();
  set_thread_count(1);
  EXPECT_EQ(run(), several);
}

TEST_P(Parallel, MayBeNested) {
  std::atomic<int> calls = 0;
  parallel_for(8, [&](std::size_t) { parallel_for(8, [&](std::size_t) { calls++; }); });
  EXPECT_EQ(calls, 64);
}

TEST_P(Parallel, FinishesBeforeItReturns) {
  std::atomic<int> finished = 0;
  parallel_for(16, [&](std::size_t) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    finished++;
  });
  EXPECT_EQ(finished.load(), 16);
}

INSTANTIATE_TEST_SUITE_P(Threads, Parallel, testing::Values(1, 2, 4));

TEST(ThreadCount, IsWhatWasSetAndZeroMeansEveryCore) {
  set_thread_count(3);
  EXPECT_EQ(thread_count(), 3);
  set_thread_count(0);
  EXPECT_EQ(thread_count(), static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
}

TEST(ThreadCount, OneKeepsTheWorkOnTheCallingThread) {
  set_thread_count(1);
  std::set<std::thread::id> threads;
  parallel_for(100, [&](std::size_t) { threads.insert(std::this_thread::get_id()); });
  set_thread_count(0);
  EXPECT_EQ(threads, std::set<std::thread::id>{std::this_thread::get_id()});
}

// Workers do not come along into a child, and what waits for them waits for ever: the alarm ends it then.
TEST(ThreadCount, AChildOfForkMaySetItAndWorkAndEnd) {
  set_thread_count(4);
  parallel_for(1000, [](std::size_t) { std::this_thread::yield(); });
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(20);
    std::atomic<int> calls = 0;
    for (const int threads : {2, 0, 1, 3}) {
      set_thread_count(threads);
      parallel_for(100, [&](std::size_t) { calls++; });
    }
    ::_exit(calls == 400 ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  set_thread_count(0);
}

}  // namespace
}  // namespace panoptic
