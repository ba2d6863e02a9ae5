// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/voxel_block.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <random>
#include <set>
#include <tuple>

#include "panoptic/map/voxel_grid.h"
#include "panoptic/parallel.h"
#include "tests/block_planes.h"

namespace panoptic {
namespace {

auto values(const Voxel& v) {
  return std::tuple(v.distance, v.weight, v.label_weight, v.vote_sum, v.label, v.red, v.green, v.blue);
}

Voxel some_voxel(std::mt19937& random) {
  const auto number = [&] { return static_cast<float>(random() % 1000); };
  const auto word = [&] { return static_cast<std::uint16_t>(random()); };
  return {number() - 500, number() + 1, number(), number(), word(), word(), word(), word()};
}

TEST(VoxelBlock, OffsetsAreThoseOfBricksAndTheirVoxels) {
  std::set<int> all;
  for (int brick = 0; brick < kBlockBricks; ++brick) {
    for (int voxel = 0; voxel < kBrickVoxels; ++voxel) {
      const int offset = offset_in_block(brick, voxel);
      ASSERT_EQ(brick_of(offset), brick);
      ASSERT_EQ(voxel_in_brick(offset), voxel);
      all.insert(offset);
    }
  }
  EXPECT_EQ(all.size(), static_cast<std::size_t>(kBlockVoxels));
  EXPECT_EQ(offset_in_block(1 + 4 * 2 + 16 * 3, 3 + 4 * 1 + 16 * 2), voxel_offset(4 + 3, 8 + 1, 12 + 2));
}

TEST(VoxelBlock, ForgetsVoxelsAndStoresThemNoMore) {
  BrickPool pool;
  std::mt19937 random(4);
  for (int round = 0; round < 200; ++round) {
    VoxelBlock block(pool);
    std::vector<Voxel> plain(kBrickVoxels);
    const int brick = static_cast<int>(random() % kBlockBricks);
    const std::uint64_t stored = std::uint64_t{random()} << 32 | random();
    const std::uint64_t forgotten = (std::uint64_t{random()} << 32 | random()) | (round % 10 == 0 ? stored : 0);
    for (int v = 0; v < kBrickVoxels; ++v) {
      if ((stored >> v & 1) == 0) continue;
      const Voxel voxel = some_voxel(random);
      block.set(offset_in_block(brick, v), voxel);
      if ((forgotten >> v & 1) == 0) plain[static_cast<std::size_t>(v)] = voxel;
    }
    block.forget(brick, forgotten);
    EXPECT_EQ(block.brick(brick).stored(), stored & ~forgotten);
    for (int v = 0; v < kBrickVoxels; ++v) {
      ASSERT_EQ(values(block.at(offset_in_block(brick, v))), values(plain[static_cast<std::size_t>(v)]));
    }
    block.set_label(offset_in_block(brick, 9), 3);  // takes the place of what was there, if it was forgotten
    EXPECT_EQ(block.weight(offset_in_block(brick, 9)), plain[9].weight);
  }
}

TEST(VoxelBlock, HoldsWhatAPlainArrayHolds) {
  BrickPool pool;
  VoxelBlock block(pool);
  std::vector<Voxel> plain(kBlockVoxels);
  std::mt19937 random(1);
  for (int step = 0; step < 6000; ++step) {
    const int offset = static_cast<int>(random() % kBlockVoxels);
    const auto i = static_cast<std::size_t>(offset);
    switch (random() % 4) {
      case 0:
        plain[i].label = static_cast<std::uint16_t>(random());
        block.set_label(offset, plain[i].label);
        break;
      case 1:
        plain[i].label_weight = 7;
        block.set_label_weight(offset, 7);
        break;
      default:
        plain[i] = some_voxel(random);
        block.set(offset, plain[i]);
    }
  }
  BlockPlanes planes;
  block.unpack(planes);
  for (int offset = 0; offset < kBlockVoxels; ++offset) {
    const auto i = static_cast<std::size_t>(offset);
    ASSERT_EQ(values(block.at(offset)), values(plain[i]));
    ASSERT_EQ(std::tuple(block.distance(offset), block.weight(offset), block.label_weight(offset), block.vote_sum(offset),
                         block.label(offset)),
              std::tuple(plain[i].distance, plain[i].weight, plain[i].label_weight, plain[i].vote_sum, plain[i].label));
    ASSERT_EQ(std::tuple(planes.distance[i], planes.weight[i], planes.label_weight[i], planes.vote_sum[i], planes.label[i],
                         planes.red[i], planes.green[i], planes.blue[i]),
              values(plain[i]));
  }
}

TEST(VoxelBlock, PacksAndCopiesEveryBit) {
  BrickPool pool;
  BrickPool other_pool;
  std::mt19937 random(2);
  for (const unsigned in : {1U, 2U, 50U, 4000U}) {
    VoxelBlock block(pool);
    VoxelBlock copy(other_pool);
    copy.set(17, some_voxel(random));  // which the copy must not keep
    for (int offset = 0; offset < kBlockVoxels; ++offset) {
      if (random() % in == 0) block.set(offset, some_voxel(random));
    }
    const BlockPlanes planes = test::planes_of(block);
    VoxelBlock packed(pool);
    packed.pack(planes);
    copy.copy(packed);
    const BlockPlanes again = test::planes_of(copy);
    EXPECT_EQ(std::memcmp(&planes, &again, sizeof planes), 0);
  }
}

TEST(VoxelBlock, StoresOnlyWhatHoldsAnything) {
  BrickPool pool;
  VoxelBlock block(pool);
  const auto planes = std::make_unique<BlockPlanes>();
  planes->blue[5] = 1;
  planes->vote_sum[4095] = 0.5F;
  block.pack(*planes);
  int stored = 0;
  for (int n = 0; n < kBlockBricks; ++n) stored += block.brick(n).count();
  EXPECT_EQ(stored, 2);
  EXPECT_EQ(pool.bytes(), 2U * 8 * kVoxelBytes);
}

TEST(VoxelBlock, RenamesLabelsAndSaysSo) {
  BrickPool pool;
  VoxelBlock block(pool);
  for (int offset = 0; offset < 100; ++offset) block.set_label(offset, static_cast<std::uint16_t>(offset % 3));
  std::vector<std::uint16_t> new_label = {0, 1, 2, 9};
  EXPECT_FALSE(block.rename_labels(new_label));
  new_label[2] = 3;
  EXPECT_TRUE(block.rename_labels(new_label));
  for (int offset = 0; offset < 100; ++offset) ASSERT_EQ(block.label(offset), offset % 3 == 2 ? 3 : offset % 3);
}

TEST(VoxelBlock, PaddingStaysZeroSoThatItNeverHoldsUpArithmetic) {
  BrickPool pool;
  VoxelBlock block(pool);
  for (int voxel = 0; voxel < kBrickVoxels; voxel += 3) block.set(offset_in_block(9, voxel), {.distance = 1, .weight = 2});
  const Brick& brick = block.brick(9);
  ASSERT_EQ(brick.count(), 22);
  ASSERT_EQ(brick.capacity(), 24);
  for (int i = brick.count(); i < brick.capacity(); ++i) EXPECT_EQ(brick.plane(FloatPlane::kWeight)[i], 0);
}

TEST(VoxelGrid, SurfaceBitsAreThoseOfTheDefinition) {
  BrickPool pool;
  VoxelBlock block(pool);
  std::mt19937 random(3);
  for (int offset = 0; offset < kBlockVoxels; ++offset) {
    if (random() % 3 != 0) continue;
    block.set(offset, {.distance = static_cast<float>(random() % 9) - 4, .weight = static_cast<float>(random() % 3)});
  }
  const BlockBits bits = surface_bits(block, 2);
  for (int offset = 0; offset < kBlockVoxels; ++offset) {
    const bool expected = block.weight(offset) > 0 && std::abs(block.distance(offset)) <= 2;
    ASSERT_EQ((bits[static_cast<std::size_t>(offset / kBlockSide)] >> (offset % kBlockSide) & 1) != 0, expected);
  }
}

TEST(BrickPool, GivesEveryThreadMemoryOfItsOwnAndTakesItBack) {
  BrickPool pool;
  constexpr std::size_t kTasks = 64;
  const auto fill_and_check = [&] {
    parallel_for(kTasks, [&](std::size_t task) {
      VoxelBlock block(pool);
      for (int offset = 0; offset < kBlockVoxels; offset += 2) {
        block.set(offset, {.weight = static_cast<float>(task + 1), .label = static_cast<std::uint16_t>(offset)});
      }
      for (int offset = 0; offset < kBlockVoxels; offset += 2) {
        ASSERT_EQ(block.weight(offset), static_cast<float>(task + 1));
        ASSERT_EQ(block.label(offset), offset);
      }
      block.pack({});  // gives everything back
    });
  };
  fill_and_check();
  const std::size_t once = pool.bytes();
  for (int round = 0; round < 3; ++round) fill_and_check();
  EXPECT_LE(pool.bytes(), 2 * once) << "what was given back is given out again";
}

}  // namespace
}  // namespace panoptic
