// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The map under a memory limit is the map without one.
#include "panoptic/map/block_pager.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <numeric>
#include <random>

#include "panoptic/base/memory.h"
#include "panoptic/parallel.h"
#include "panoptic/voxel_map.h"
#include "tests/block_planes.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

using testing::AllOf;
using testing::Gt;
using testing::HasSubstr;
using testing::Le;

constexpr int kLimit_mb = 8;  // 97 blocks
constexpr Slot kBlocks = 700;
constexpr double kMostInMemory_mb = 1.25 * kLimit_mb;

MapOptions limited(const std::filesystem::path& folder) { return {.memory_limit_mb = kLimit_mb, .swap_folder = folder.string()}; }

// Pages of files that this process has in memory.
double resident_file_mb() {
  std::ifstream statm("/proc/self/statm");
  double size = 0;
  double resident = 0;
  double shared = 0;
  statm >> size >> resident >> shared;
  return shared * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

BlockIndex index_of(Slot slot) {
  const auto s = static_cast<std::int32_t>(slot);
  return {s % 10, s / 10 % 10, s / 100};
}

void write_something(VoxelBlock& target, unsigned seed) {
  test::BlockEdit edit(target);
  BlockPlanes& block = *edit;
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < kBlockVoxels; i += 3) {
    block.distance[i] += static_cast<float>(random() % 1000);
    block.label[i] = static_cast<std::uint16_t>(random() % 50);
    block.blue[i] ^= static_cast<std::uint16_t>(random());
  }
}

// The same life for any map: it grows, is written here and there, and is looked at.
std::uint64_t hash_after_a_life(VoxelMap& map) {
  for (Slot slot = 0; slot < kBlocks; ++slot) write_something(map.block(map.allocate(index_of(slot))), slot);
  std::mt19937 random(7);
  for (unsigned turn = 0; turn < 20; ++turn) {
    map.begin_epoch();
    std::vector<Slot> slots(kBlocks);
    std::iota(slots.begin(), slots.end(), Slot{0});
    std::shuffle(slots.begin(), slots.end(), random);
    slots.resize(60);
    parallel_for(slots.size(), [&](std::size_t i) { write_something(map.block(slots[i]), turn); });
  }
  return map.hash();
}

TEST(BlockPager, AMapUnderALimitIsTheSameMap) {
  VoxelMap whole{MapOptions{}};
  VoxelMap paged(limited(test::fresh_folder()));
  EXPECT_EQ(hash_after_a_life(paged), hash_after_a_life(whole));
  EXPECT_EQ(ids_in_use(paged), ids_in_use(whole));
  EXPECT_THAT(paged.pager()->blocks_given_back(), Gt(kBlocks));
  EXPECT_EQ(whole.pager(), nullptr);
}

TEST(BlockPager, KeepsTheProcessBelowTheLimit) {
  VoxelMap map(limited(test::fresh_folder()));
  const double before_mb = resident_file_mb();
  double most_mb = 0;
  for (Slot slot = 0; slot < kBlocks; ++slot) {
    write_something(map.block(map.allocate(index_of(slot))), slot);
    most_mb = std::max(most_mb, resident_file_mb() - before_mb);
  }
  for (Slot slot = 0; slot < kBlocks; ++slot) {
    write_something(map.block(slot), slot);
    most_mb = std::max(most_mb, resident_file_mb() - before_mb);
  }
  EXPECT_THAT(most_mb, Le(kMostInMemory_mb));
  EXPECT_THAT(static_cast<double>(map.memory_bytes()) / 1e6, Le(kMostInMemory_mb));
}

TEST(BlockPager, APointerStaysGoodWhileItsBlockIsAway) {
  VoxelMap map(limited(test::fresh_folder()));
  VoxelBlock* const first = &map.block(map.allocate({0, 0, 0}));
  first->set(17, {.distance = 5});
  for (Slot slot = 1; slot < kBlocks; ++slot) write_something(map.block(map.allocate(index_of(slot))), slot);
  EXPECT_EQ(first->distance(17), 5);
  first->set(18, {.distance = 6});  // written behind the pager's back
  for (Slot slot = 1; slot < kBlocks; ++slot) map.block(slot).set(0, {.weight = 1});
  EXPECT_EQ(map.find({0, 0, 0})->distance(18), 6);
  EXPECT_EQ(map.find({0, 0, 0}), first);
}

TEST(BlockPager, BlocksThatAreUsedStay) {
  BlockPager pager(100 * sizeof(BlockPlanes), test::fresh_folder());
  std::deque<VoxelBlock> blocks;
  const auto add_full_block = [&] {
    VoxelBlock& block = blocks.emplace_back(pager.add());
    for (int n = 0; n < kBlockBricks; ++n) block.store(n, ~std::uint64_t{0});
  };
  for (int i = 0; i < 90; ++i) add_full_block();
  for (int turn = 0; turn < 40; ++turn) {
    pager.tick();
    for (std::size_t slot = 0; slot < 60; ++slot) pager.touch(slot);
    add_full_block();
  }
  // 60 of 130 blocks were always in use; some of the others went, each once.
  EXPECT_THAT(pager.blocks_given_back(), Le(70U));
  EXPECT_THAT(pager.blocks_given_back(), Gt(0U));
}

TEST(BlockPager, ThreadsLoseNothingWhileBlocksComeAndGo) {
  VoxelMap map(limited(test::fresh_folder()));
  for (Slot slot = 0; slot < kBlocks; ++slot) map.allocate(index_of(slot));
  for (int round = 0; round < 10; ++round) {
    parallel_for(kBlocks, [&](std::size_t i) {
      test::BlockEdit block(map.block(static_cast<Slot>((i * 311) % kBlocks)));  // far from each other
      for (float& weight : block->weight) weight += 1;
    });
  }
  for (Slot slot = 0; slot < kBlocks; ++slot) {
    const BlockPlanes block = test::planes_of(map.block(slot));
    ASSERT_EQ(std::count(block.weight.begin(), block.weight.end(), 10.0F), kBlockVoxels) << slot;
  }
}

// Adds voxels of so many bytes, in blocks all of whose voxels are stored.
void fill(BlockPager& pager, std::size_t bytes, std::deque<VoxelBlock>& blocks) {
  for (std::size_t i = 0; i < bytes / sizeof(BlockPlanes); ++i) {
    VoxelBlock& block = blocks.emplace_back(pager.add());
    for (int n = 0; n < kBlockBricks; ++n) block.store(n, ~std::uint64_t{0});
  }
}

TEST(BlockPager, VoxelsGetWhatTheRestOfTheProcessLeaves) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer takes memory of its own for what is allocated";
  constexpr std::size_t kVoxels = 60'000'000;
  BlockPager pager(resident_bytes() + BlockPager::kHeadroomBytes + kVoxels, test::fresh_folder(), BlockPager::Bounds::kProcess);
  std::deque<VoxelBlock> blocks;
  fill(pager, kVoxels * 9 / 10, blocks);
  EXPECT_EQ(pager.blocks_given_back(), 0U);
  const std::vector<char> others(35'000'000, 1);
  pager.tick();
  EXPECT_LE(pager.bytes_in_memory(), kVoxels - others.size());
  EXPECT_LE(resident_bytes(), pager.limit_bytes());
  fill(pager, kVoxels, blocks);
  EXPECT_LE(resident_bytes(), pager.limit_bytes());
  EXPECT_GT(pager.bytes_in_memory(), BlockPager::kFewestBytes);
}

TEST(BlockPager, TheLeastLimitIsWhatTheProcessTakesAndSomeForTheNextStage) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer takes memory of its own for what is allocated";
  BlockPager pager(1, test::fresh_folder(), BlockPager::Bounds::kProcess);
  const std::size_t least = pager.least_limit_bytes();
  EXPECT_NEAR(static_cast<double>(least),
              static_cast<double>(resident_bytes() + BlockPager::kHeadroomBytes + BlockPager::kFewestBytes), 2e6);
  const std::vector<char> more(20'000'000, 1);
  EXPECT_NEAR(static_cast<double>(pager.least_limit_bytes() - least), static_cast<double>(more.size()), 2e6);
}

// In a process of its own, because what is left out stays left out.
TEST(BlockPager, MemoryOfNetworksIsLeftOutOfTheLimit) {
  if (test::kSanitized) GTEST_SKIP() << "a sanitizer takes memory of its own for what is allocated";
  EXPECT_EXIT(
      {
        BlockPager pager(1, test::fresh_folder(), BlockPager::Bounds::kProcess);
        const std::size_t before = pager.least_limit_bytes();
        std::vector<char> network;
        {
          const LeftOutOfLimit loading;
          network.assign(40'000'000, 1);
        }
        std::exit(pager.least_limit_bytes() < before + 4'000'000 && network[9] == 1 ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(BlockPager, LeavesNoFileBehind) {
  const auto folder = test::fresh_folder();
  VoxelMap map(limited(folder));
  map.allocate({1, 2, 3});
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(BlockPager, RefusesAFolderThatIsNotThere) {
  const auto nowhere = test::fresh_folder() / "nowhere";
  EXPECT_THAT(test::error_of([&] { VoxelMap map(limited(nowhere)); }),
              AllOf(HasSubstr("map.memory_limit_mb"), HasSubstr(nowhere.string()), HasSubstr("map.swap_folder")));
}

TEST(BlockPager, AFullDiskIsAnErrorAndLeavesTheMapAsItWas) {
  VoxelMap map(limited(test::fresh_folder()));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit one_chunk{40U << 20, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &one_chunk), 0);
  Slot made = 0;
  EXPECT_THAT(test::error_of([&] {
                for (; made < kBlocks; ++made) map.allocate(index_of(made));
              }),
              AllOf(HasSubstr("for the map"), HasSubstr("free some space")));
  EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(made, Gt(0U));
  EXPECT_EQ(map.block_count(), made);
  EXPECT_EQ(map.find(index_of(made)), nullptr);
  EXPECT_EQ(map.allocate(index_of(made)), made);  // there is space again
}

}  // namespace
}  // namespace panoptic
