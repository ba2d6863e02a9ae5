// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/block_codec.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <memory>
#include <random>

namespace panoptic {
namespace {

bool same(const VoxelBlock& a, const VoxelBlock& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// A block as mapping leaves it: a noisy surface, and nothing far from it.
std::unique_ptr<VoxelBlock> mapped_block(std::mt19937& random) {
  auto block = std::make_unique<VoxelBlock>();
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    const float distance = 0.024F * (static_cast<float>(v / 256) - 7.5F) + static_cast<float>(random() % 1000) * 1e-5F;
    if (std::abs(distance) > 0.096F) continue;
    block->distance[v] = distance;
    block->weight[v] = static_cast<float>(1 + random() % 100000) * 0.01F;
    block->label[v] = static_cast<std::uint16_t>(v % 16 < 8 ? 3 : 44);
    const float weights[] = {block->weight[v], 4 * block->weight[v], 0, 0.7F * block->weight[v]};
    block->label_weight[v] = weights[random() % 4];
    block->red[v] = static_cast<std::uint16_t>(30000 + random() % 4000);
    block->green[v] = static_cast<std::uint16_t>(block->red[v] - 300 + random() % 60);
    block->blue[v] = static_cast<std::uint16_t>(random() % 50 == 0 ? 0 : block->green[v] + random() % 60);
  }
  return block;
}

void expect_round_trip(const VoxelBlock& block) {
  const Bytes bytes = BlockEncoder().encode(block);
  auto decoded = std::make_unique<VoxelBlock>();
  EXPECT_EQ(BlockDecoder().decode(bytes, *decoded), nullptr);
  EXPECT_TRUE(same(block, *decoded));
}

TEST(BlockCodec, DecodesWhatItEncodedBitForBit) {
  std::mt19937 random(3);
  for (int i = 0; i < 30; ++i) expect_round_trip(*mapped_block(random));
}

TEST(BlockCodec, KeepsEveryBitOfBlocksThatNoMappingWouldLeave) {
  std::mt19937 random(4);
  constexpr float kOdd[] = {0.0F, -0.0F, 1e-45F, -1e-40F, std::numeric_limits<float>::max(), -std::numeric_limits<float>::max(),
                            1.0F, -1.0F, 3e-39F, 1e30F};
  for (int i = 0; i < 30; ++i) {
    auto block = std::make_unique<VoxelBlock>();
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      if (random() % 3 == 0) continue;
      block->distance[v] = kOdd[random() % std::size(kOdd)];
      block->weight[v] = std::abs(kOdd[random() % std::size(kOdd)]);
      block->label_weight[v] = std::abs(kOdd[random() % std::size(kOdd)]);
      block->label[v] = static_cast<std::uint16_t>(random());
      block->red[v] = static_cast<std::uint16_t>(random());
      block->green[v] = static_cast<std::uint16_t>(random());
      block->blue[v] = static_cast<std::uint16_t>(random());
    }
    // Predictions that overflow would not be the same everywhere: the extremes stand alone.
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      if (std::abs(block->distance[v]) > 1e37F) block->distance[v] = v % 2 == 0 ? 1e37F : -1e37F;
      if (block->weight[v] > 1e37F) block->weight[v] = 1e37F;
    }
    expect_round_trip(*block);
  }
}

TEST(BlockCodec, VoxelsThatHoldNothingCostNothing) {
  EXPECT_LT(BlockEncoder().encode({}).size(), 40U);
  auto block = std::make_unique<VoxelBlock>();
  block->weight[1234] = 1;
  EXPECT_LT(BlockEncoder().encode(*block).size(), 150U);
  expect_round_trip(*block);
  expect_round_trip({});
}

TEST(BlockCodec, RefusesADistanceThatIsNotANumberAndNegativeWeights) {
  const auto complaint = [](const VoxelBlock& block) {
    auto decoded = std::make_unique<VoxelBlock>();
    const char* wrong = BlockDecoder().decode(BlockEncoder().encode(block), *decoded);
    return std::string(wrong == nullptr ? "" : wrong);
  };
  auto block = std::make_unique<VoxelBlock>();
  block->weight[7] = 1;
  block->distance[7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(complaint(*block), "");
  block->distance[7] = std::numeric_limits<float>::infinity();
  EXPECT_NE(complaint(*block), "");
  block->distance[7] = 0;
  block->weight[7] = -1;
  EXPECT_EQ(complaint(*block), "a weight is negative or not a number");
  block->weight[7] = 1;
  block->label_weight[7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(complaint(*block), "a weight is negative or not a number");
}

TEST(BlockCodec, RefusesWhatIsCutOffAndSurvivesWhatIsChanged) {
  std::mt19937 random(5);
  const Bytes good = BlockEncoder().encode(*mapped_block(random));
  auto block = std::make_unique<VoxelBlock>();
  BlockDecoder decoder;
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 16) {
    EXPECT_NE(decoder.decode(std::span(good).first(size), *block), nullptr) << size;
  }
  for (int i = 0; i < 2000; ++i) {
    Bytes bad = good;
    bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
    *block = {};
    if (decoder.decode(bad, *block) != nullptr) continue;
    for (const float d : block->distance) ASSERT_TRUE(std::isfinite(d));
    for (const float w : block->weight) ASSERT_TRUE(std::isfinite(w) && w >= 0);
  }
}

TEST(BlockCodec, RefusesAFrameThatIsLargerThanABlock) {
  const Bytes zeros(50'000'000, 0);
  const Bytes bomb = Compressor().compress(zeros);
  ASSERT_LT(bomb.size(), 10'000U);
  auto block = std::make_unique<VoxelBlock>();
  EXPECT_STREQ(BlockDecoder().decode(bomb, *block), "its voxels cannot be decompressed");
}

}  // namespace
}  // namespace panoptic
