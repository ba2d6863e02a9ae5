// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The real program on a disk that fails at the first, the second, ... call. What is promised: docs/reliability.md.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <map>
#include <random>
#include <set>

#include "panoptic/profile.h"
#include "tests/faults/operations.h"
#include "tests/fresh_seed.h"

namespace panoptic {
namespace {

using test::Fault;
using test::FaultWorld;
using test::FaultyRun;
using test::Operation;
using test::Undisturbed;

constexpr int kForEver = 0;
constexpr std::array<Fault, 13> kFaults = {{
    {"the disk is full", "create,write,resize,folder", ENOSPC, kForEver},
    {"a write fails", "write", EIO},
    {"a sync fails", "sync", EIO},
    {"closing fails", "close", EIO},
    {"a name cannot be changed", "rename", EACCES},
    {"a read fails", "read", EIO},
    {"a file cannot be opened", "open,create", EMFILE, 3},
    {"a file's state cannot be read", "look", EIO},
    {"a folder cannot be listed", "list", EIO},
    {"nothing can be removed", "remove", EIO, kForEver},
    {"a size cannot be changed", "resize", EIO},
    {"a call is interrupted", "open,create,read,write,close", EINTR},
    {"reads and writes are short", "read,write", 0, kForEver},
}};

const Fault& fault_named(const std::string& name) {
  return *std::find_if(kFaults.begin(), kFaults.end(), [&](const Fault& fault) { return fault.name == name; });
}

// These must succeed as if nothing had happened.
bool is_harmless(const Fault& fault) { return fault.error == EINTR || fault.error == 0; }

struct Counts {
  long runs = 0;
  long failed = 0;   // with exit code 1
  long skipped = 0;  // of more calls than were tried
};

class Faults : public testing::Test {
 protected:
  // Run once for each operation.
  const Undisturbed& undisturbed(const Operation& operation) {
    const auto [at, is_new] = undisturbed_.try_emplace(operation.name);
    Undisturbed& result = at->second;
    if (!is_new) return result;
    world_.put_back(operation);
    result.before = test::files_below(world_.place());
    const test::ProgramResult program = test::run_program(operation.arguments);
    EXPECT_EQ(program.exit_code, 0) << operation.name << ": " << program.err;
    result.out = program.out;
    result.map = test::map_summary(world_.place() / "map.panoptic");
    result.files = test::files_below(world_.place());
    return result;
  }

  // Lets the call fail, and compares with what is promised.
  void try_fault(const Operation& operation, const Fault& fault, long first, const Undisturbed& expected, Counts& counts) const {
    world_.put_back(operation);
    const FaultyRun run = run_with_fault(operation.arguments, world_.root(), fault, first);
    ++counts.runs;
    counts.failed += run.program.exit_code != 0 ? 1 : 0;
    std::string wrong = complaints(world_, operation, fault, run, expected);
    if (is_harmless(fault) && run.program.exit_code != 0) wrong += "it is no reason to fail\n";
    if (wrong.empty() && operation.keeps_map && run.program.exit_code != 0) wrong += resume(operation, expected);
    EXPECT_EQ(wrong, "") << operation.name << ", " << fault.name << ", call " << first << ", "
                         << (run.failed_at.empty() ? "none failed" : run.failed_at.front()) << "\n"
                         << run.program.err;
  }

  std::string resume(const Operation& operation, const Undisturbed& expected) const {
    const test::ProgramResult resumed = test::run_program(operation.arguments);
    if (resumed.exit_code != 0) return fmt::format("it cannot be resumed: {}\n", resumed.err);
    const std::string map = test::map_summary(world_.place() / "map.panoptic");
    return map == expected.map ? "" : fmt::format("resumed it comes to {} instead of {}\n", map, expected.map);
  }

  // At every call, or at `most` of them spread evenly: the first of each share, or one of it by chance.
  Counts sweep(const Operation& operation, const Fault& fault, long most, std::mt19937* random = nullptr) {
    const Undisturbed& expected = undisturbed(operation);
    world_.put_back(operation);
    const long calls = run_with_fault(operation.arguments, world_.root(), fault, 0).calls;
    Counts counts;
    std::set<long> tried;
    const long shares = std::min(calls, most);
    for (long k = 0; k < shares; ++k) {
      const long begin = (k * calls) / shares;
      const long size = ((k + 1) * calls) / shares - begin;
      tried.insert(1 + begin + (random == nullptr ? 0 : static_cast<long>((*random)()) % size));
    }
    if (is_harmless(fault) && fault.times == kForEver) tried = {1};
    for (const long first : tried) try_fault(operation, fault, first, expected, counts);
    counts.skipped = calls - static_cast<long>(tried.size());
    return counts;
  }

  // Made once for all tests of the process: what is given stays as it is, and the rest is put back before each run.
  static FaultWorld& the_world() {
    static FaultWorld world;
    return world;
  }
  static std::map<std::string, Undisturbed>& undisturbed_runs() {
    static std::map<std::string, Undisturbed> runs;
    return runs;
  }

  FaultWorld& world_ = the_world();
  std::map<std::string, Undisturbed>& undisturbed_ = undisturbed_runs();
};

// A few calls of each kind; SlowFaults tries them all.
TEST_F(Faults, ShortAndInterruptedCallsChangeNothing) {
  EXPECT_EQ(sweep(world_.operation("map"), fault_named("reads and writes are short"), 1).runs, 1);
  EXPECT_EQ(sweep(world_.operation("map"), fault_named("a call is interrupted"), 2).runs, 2);
}

TEST_F(Faults, AFullDiskLeavesWhatWasThere) {
  for (const char* name : {"run", "map"}) {
    EXPECT_GT(sweep(world_.operation(name), fault_named("the disk is full"), 2).failed, 1) << name;
  }
}

TEST_F(Faults, ANameThatCannotBeChangedLeavesTheOlderFile) {
  for (const char* name : {"map", "mesh"}) {
    EXPECT_GT(sweep(world_.operation(name), fault_named("a name cannot be changed"), 2).failed, 0) << name;
  }
}

TEST_F(Faults, WhatIsNotOnTheDiskIsNotSaidToBe) {
  for (const char* fault : {"a sync fails", "closing fails"}) {
    EXPECT_GT(sweep(world_.operation("scene"), fault_named(fault), 2).failed, 0) << fault;
    sweep(world_.operation("regularize"), fault_named(fault), 2);
  }
}

TEST_F(Faults, WhatCannotBeReadIsNotTakenForAbsent) {
  for (const char* fault : {"a read fails", "a file's state cannot be read", "a folder cannot be listed"}) {
    for (const char* name : {"run_paged", "mesh"}) sweep(world_.operation(name), fault_named(fault), 2);
  }
}

// No file can be longer, the program's own output neither; the signal that comes with it ends a program that does not expect it.
std::function<void()> limit_file_bytes(rlim_t bytes) {
  return [bytes] {
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
  };
}

TEST(Output, ThatCannotBeWrittenIsAnError) {
  const test::ProgramResult result = test::run_program({"options"}, limit_file_bytes(200));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err, "panoptic: the standard output could not be written: free space where it goes\n");
}

TEST(Output, ThatNobodyTakesEndsNothingElse) {
  const test::ProgramResult result = test::run_program({"info", "/nowhere/map.panoptic"}, limit_file_bytes(5));
  EXPECT_EQ(result.exit_code, 1) << "not a signal";
  EXPECT_EQ(result.err, "panop");
}

TEST_F(Faults, AFileThatMayGrowNoFurtherIsAnErrorAndNoSignal) {
  const Operation operation = world_.operation("scene");
  world_.put_back(operation);
  const test::ProgramResult result = test::run_program(operation.arguments, limit_file_bytes(1000));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, testing::HasSubstr("scene.glb: File too large"));
  EXPECT_EQ(test::files_below(world_.place())["scene.glb"], "older");
}

class SlowFaults : public Faults, public testing::WithParamInterface<std::string> {};

TEST_P(SlowFaults, LoseNothing) {
  const char* chosen = std::getenv("PANOPTIC_FAULTS_AT_MOST");
  const long most = chosen == nullptr ? 2 : std::max(1L, std::strtol(chosen, nullptr, 10));
  const Operation operation = world_.operation(GetParam());
  std::mt19937 random(test::fresh_seed());
  for (const Fault& fault : kFaults) {
    const Stopwatch stopwatch;
    const Counts counts = sweep(operation, fault, most, &random);
    fmt::print("{:<12}{:<32}{:>4} tried, {:>4} of them ended with an error, {:>5} calls not tried, {:.1f} s\n", operation.name,
               fault.name, counts.runs, counts.failed, counts.skipped, stopwatch.seconds());
    std::fflush(stdout);
  }
}

INSTANTIATE_TEST_SUITE_P(Sweep, SlowFaults, testing::ValuesIn(FaultWorld::operations()),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace panoptic
