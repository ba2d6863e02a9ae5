// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/voxel_map.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <random>

#include "panoptic/base/config.h"
#include "panoptic/map/block_key.h"
#include "panoptic/map/cached_lookup.h"
#include "panoptic/map/option_fields.h"
#include "panoptic/parallel.h"
#include "tests/block_planes.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<BlockIndex> random_indices(unsigned seed, std::size_t count, std::int32_t reach) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::int32_t> coordinate(-reach, reach);
  std::vector<BlockIndex> indices(count);
  for (BlockIndex& index : indices) index = {coordinate(random), coordinate(random), coordinate(random)};
  return indices;
}

// Some bits for every plane, a function of the block's place alone.
void fill(BlockPlanes& block, BlockIndex index) {
  std::mt19937 random(static_cast<unsigned>(mixed(pack(index))));
  for (std::size_t i = 0; i < kBlockVoxels; i += 5) {
    block.distance[i] = static_cast<float>(random() % 1000) / 1000;
    block.weight[i] = static_cast<float>(random() % 100);
    block.label_weight[i] = static_cast<float>(random() % 100);
    block.vote_sum[i] = block.label_weight[i] + static_cast<float>(i % 3);
    block.label[i] = static_cast<std::uint16_t>(random());
    block.red[i] = static_cast<std::uint16_t>(random());
    block.green[i] = static_cast<std::uint16_t>(random());
    block.blue[i] = static_cast<std::uint16_t>(random());
  }
}

VoxelMap filled_map(const std::vector<BlockIndex>& indices) {
  VoxelMap map{MapOptions{}};
  for (const BlockIndex index : indices) fill(*test::BlockEdit(map.block(map.allocate(index))), index);
  return map;
}

TEST(VoxelBlock, VoxelOffsetsRunXFastest) {
  EXPECT_EQ(voxel_offset(0, 0, 0), 0);
  EXPECT_EQ(voxel_offset(1, 0, 0), 1);
  EXPECT_EQ(voxel_offset(0, 1, 0), 16);
  EXPECT_EQ(voxel_offset(0, 0, 1), 256);
  EXPECT_EQ(voxel_offset(15, 15, 15), kBlockVoxels - 1);
}

TEST(VoxelMap, AgreesWithAnOrderedMapOnRandomIndices) {
  for (const std::int32_t reach : {4, 30, kMaxBlockCoordinate}) {  // dense and sparse, negative and positive, two rehashes
    VoxelMap map{MapOptions{}};
    std::map<BlockIndex, Slot> reference;
    for (const BlockIndex index : random_indices(9, 1200, reach)) {
      const auto [place, is_new] = reference.try_emplace(index, static_cast<Slot>(reference.size()));
      ASSERT_EQ(map.find_slot(index) == VoxelMap::kNoSlot, is_new);
      ASSERT_EQ(map.allocate(index), place->second);
    }
    ASSERT_EQ(map.block_count(), reference.size());
    for (const auto& [index, slot] : reference) {
      ASSERT_EQ(map.find_slot(index), slot);
      ASSERT_EQ(map.find(index), &map.block(slot));
      ASSERT_EQ(map.index_of(slot), index);
    }
    for (const BlockIndex index : random_indices(10, 400, reach)) {
      ASSERT_EQ(map.find(index) != nullptr, reference.count(index) == 1);
    }
  }
}

TEST(VoxelMap, NewBlocksAreEmptyAndNeverMove) {
  VoxelMap map{MapOptions{}};
  const VoxelBlock* first = &map.block(map.allocate({-1, 2, -3}));
  for (const BlockIndex index : random_indices(3, 1200, 20)) map.allocate(index);
  EXPECT_EQ(map.find({-1, 2, -3}), first);
  const BlockPlanes zeros;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockPlanes planes = test::planes_of(map.block(slot));
    ASSERT_EQ(std::memcmp(&planes, &zeros, sizeof zeros), 0);
    for (int n = 0; n < kBlockBricks; ++n) ASSERT_EQ(map.block(slot).brick(n).stored(), 0U);
  }
}

TEST(VoxelMap, FindsNothingOutsideTheRange) {
  VoxelMap map{MapOptions{}};
  map.allocate({kMaxBlockCoordinate, -kMaxBlockCoordinate, 0});
  EXPECT_NE(map.find({kMaxBlockCoordinate, -kMaxBlockCoordinate, 0}), nullptr);
  for (const std::int32_t outside : {kMaxBlockCoordinate + 1, -kMaxBlockCoordinate - 1, std::numeric_limits<std::int32_t>::max(),
                                     std::numeric_limits<std::int32_t>::min()}) {
    EXPECT_EQ(map.find({outside, 0, 0}), nullptr);
    EXPECT_EQ(map.find_slot({0, outside, 0}), VoxelMap::kNoSlot);
    EXPECT_EQ(map.find({0, 0, outside}), nullptr);
  }
}

TEST(VoxelMap, EpochsTellEachReaderWhatChangedSinceItLooked) {
  VoxelMap map{MapOptions{}};
  const std::uint64_t start = map.epoch();
  map.begin_epoch();
  const Slot a = map.allocate({0, 0, 0});
  const Slot b = map.allocate({5, 0, 0});
  EXPECT_THAT(map.changed_since(start), ElementsAre(a, b)) << "a new block counts as changed";
  const std::uint64_t seen_early = map.epoch();
  EXPECT_THAT(map.changed_since(seen_early), IsEmpty());
  map.begin_epoch();
  map.mark_changed(b);
  const Slot c = map.allocate({-5, 0, 0});
  map.allocate({0, 0, 0});  // there already: no change
  EXPECT_THAT(map.changed_since(seen_early), ElementsAre(b, c));
  EXPECT_THAT(map.changed_since(start), ElementsAre(a, b, c));
  EXPECT_EQ(map.changed_at(b), map.epoch());
  EXPECT_THAT(map.changed_since(map.epoch()), IsEmpty());
}

TEST(VoxelMap, HashDoesNotDependOnTheOrderOfAllocation) {
  std::vector<BlockIndex> indices = random_indices(21, 60, 3);
  const std::uint64_t expected = filled_map(indices).hash();
  std::mt19937 random(1);
  for (int i = 0; i < 5; ++i) {
    std::shuffle(indices.begin(), indices.end(), random);
    EXPECT_EQ(filled_map(indices).hash(), expected);
  }
}

TEST(VoxelMap, HashDoesNotDependOnTheThreads) {
  const VoxelMap map = filled_map(random_indices(22, 60, 3));
  set_thread_count(1);
  const std::uint64_t one = map.hash();
  set_thread_count(4);
  EXPECT_EQ(map.hash(), one);
  set_thread_count(0);
}

TEST(VoxelMap, HashChangesWithAnyBitOfAnyPlane) {
  VoxelMap map = filled_map(random_indices(23, 3, 3));
  const std::uint64_t before = map.hash();
  std::mt19937 random(2);
  for (int trial = 0; trial < 300; ++trial) {
    VoxelBlock& block = map.block(static_cast<Slot>(random() % map.block_count()));
    const std::size_t at = random() % sizeof(BlockPlanes);
    const auto bit = static_cast<unsigned char>(1U << random() % 8);
    const auto flip = [&] {
      test::BlockEdit edit(block);
      reinterpret_cast<unsigned char*>(&*edit)[at] ^= bit;
    };
    flip();
    ASSERT_NE(map.hash(), before) << "byte " << at;
    flip();
  }
  EXPECT_EQ(map.hash(), before);
}

TEST(VoxelMap, HashTellsPlacesAndSwappedVoxelsApart) {
  const VoxelMap empty{MapOptions{}};
  VoxelMap here{MapOptions{}};
  VoxelMap there{MapOptions{}};
  here.allocate({1, 2, 3});
  there.allocate({3, 2, 1});
  EXPECT_NE(here.hash(), there.hash());
  EXPECT_NE(here.hash(), empty.hash());
  const std::uint64_t zero = here.hash();
  here.block(0).set_label(10, 1);
  const std::uint64_t at_10 = here.hash();
  here.block(0).set_label(10, 0);
  here.block(0).set_label(11, 1);
  EXPECT_NE(here.hash(), at_10);
  EXPECT_NE(here.hash(), zero);
}

// The value itself is a promise between builds: release, dev, asan, tsan and clang must find the same one.
TEST(VoxelMap, HashOfAKnownMapIsGolden) {
  VoxelMap map{MapOptions{}};
  for (std::int32_t i = -2; i <= 2; ++i) fill(*test::BlockEdit(map.block(map.allocate({i, -i, 7 * i}))), {i, -i, 7 * i});
  EXPECT_EQ(map.hash(), 13198270742109853861ULL);
}

TEST(VoxelMap, SizesFollowTheOptions) {
  const VoxelMap map{MapOptions{0.01F, 5}};
  EXPECT_FLOAT_EQ(map.voxel_size_m(), 0.01F);
  EXPECT_FLOAT_EQ(map.truncation_m(), 0.05F);
  EXPECT_FLOAT_EQ(map.block_size_m(), 0.16F);
}

TEST(VoxelMap, MemoryIsThatOfItsBlocks) {
  VoxelMap map{MapOptions{}};
  const std::size_t empty = map.memory_bytes();
  for (std::int32_t i = 0; i < 100; ++i) map.allocate({i, 0, 0});
  const std::size_t without_voxels = map.memory_bytes();
  EXPECT_GE(without_voxels - empty, 100 * sizeof(VoxelBlock));
  EXPECT_LE(without_voxels - empty, 110 * sizeof(VoxelBlock));
  constexpr std::size_t kVoxels = 40 * 40;
  for (std::size_t v = 0; v < kVoxels; ++v) map.block(static_cast<Slot>(v / 40)).set(static_cast<int>(v % 40), {.weight = 1});
  EXPECT_EQ(map.observed_voxels(), kVoxels);
  EXPECT_GE(map.memory_bytes() - without_voxels, kVoxels * kVoxelBytes);
  EXPECT_LE(map.memory_bytes() - without_voxels, 3 * kVoxels * kVoxelBytes) << "bricks of 4 x 2 or 4 x 3 voxels are 8 or 16";
}

TEST(MapOptions, RefusesSizesThatMakeNoSense) {
  MapOptions options;
  for (const char* bad :
       {"voxel_size_m = 0", "voxel_size_m = -1", "voxel_size_m = nan", "truncation_voxels = 0.5", "voxel_size_m = 3"}) {
    test::error_of([&] { read_toml_text(bad, "options.toml", fields(options)); });
  }
}

TEST(CachedLookup, AgreesWithTheMap) {
  const VoxelMap map = filled_map(random_indices(30, 200, 3));
  CachedLookup lookup(map);
  for (BlockIndex index : random_indices(31, 3000, 4)) {
    for (int repeat = 0; repeat < 2; ++repeat) ASSERT_EQ(lookup.find(index), map.find(index));
    index.x++;
    ASSERT_EQ(lookup.find(index), map.find(index));
  }
}

TEST(VoxelMap, KnowsWhichIdsAnyVoxelHolds) {
  VoxelMap map({});
  map.block(map.allocate({0, 0, 0})).set_label(77, 9);
  map.block(map.allocate({-5, 2, 1})).set_label(4095, 65534);
  const std::vector<bool> used = ids_in_use(map);
  ASSERT_EQ(used.size(), 65536U);
  EXPECT_EQ(std::count(used.begin(), used.end(), true), 3);
  EXPECT_TRUE(used[0] && used[9] && used[65534]);
}

}  // namespace
}  // namespace panoptic
