// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/block_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <random>

#include "panoptic/base/compression.h"

namespace panoptic {
namespace {

bool same(const BlockPlanes& a, const BlockPlanes& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// A block as mapping leaves it: a noisy surface, and nothing far from it.
std::unique_ptr<BlockPlanes> mapped_block(std::mt19937& random) {
  auto block = std::make_unique<BlockPlanes>();
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    const float distance = 0.024F * (static_cast<float>(v / 256) - 7.5F) + static_cast<float>(random() % 1000) * 1e-5F;
    if (std::abs(distance) > 0.096F) continue;
    block->distance[v] = distance;
    block->weight[v] = static_cast<float>(1 + random() % 100000) * 0.01F;
    block->label[v] = static_cast<std::uint16_t>(v % 16 < 8 ? 3 : 44);
    const float weight = block->weight[v];
    const float sums[] = {weight, 4 * weight, 0, 1.7F * weight};
    block->vote_sum[v] = sums[random() % 4];
    const float weights[] = {weight, 4 * weight, 0, 0.7F * weight, block->vote_sum[v]};
    block->label_weight[v] = std::min(block->vote_sum[v], weights[random() % 5]);
    block->red[v] = static_cast<std::uint16_t>(30000 + random() % 4000);
    block->green[v] = static_cast<std::uint16_t>(block->red[v] - 300 + random() % 60);
    block->blue[v] = static_cast<std::uint16_t>(random() % 50 == 0 ? 0 : block->green[v] + random() % 60);
  }
  return block;
}

void expect_round_trip(const BlockPlanes& block) {
  const Bytes bytes = BlockEncoder().encode(block);
  auto decoded = std::make_unique<BlockPlanes>();
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
    auto block = std::make_unique<BlockPlanes>();
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      if (random() % 3 == 0) continue;
      block->distance[v] = kOdd[random() % std::size(kOdd)];
      block->weight[v] = std::abs(kOdd[random() % std::size(kOdd)]);
      block->vote_sum[v] = std::abs(kOdd[random() % std::size(kOdd)]);
      block->label_weight[v] = std::min(block->vote_sum[v], std::abs(kOdd[random() % std::size(kOdd)]));
      block->label[v] = static_cast<std::uint16_t>(random());
      block->red[v] = static_cast<std::uint16_t>(random());
      block->green[v] = static_cast<std::uint16_t>(random());
      block->blue[v] = static_cast<std::uint16_t>(random());
    }
    // Predictions that overflow would not be the same everywhere: the extremes stand alone.
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      if (std::abs(block->distance[v]) > 1e37F) block->distance[v] = v % 2 == 0 ? 1e37F : -1e37F;
      for (auto* plane : {&block->weight, &block->vote_sum, &block->label_weight}) (*plane)[v] = std::min((*plane)[v], 1e37F);
    }
    expect_round_trip(*block);
  }
}

TEST(BlockCodec, VoxelsThatHoldNothingCostNothing) {
  EXPECT_LT(BlockEncoder().encode({}).size(), 40U);
  auto block = std::make_unique<BlockPlanes>();
  block->weight[1234] = 1;
  EXPECT_LT(BlockEncoder().encode(*block).size(), 150U);
  expect_round_trip(*block);
  expect_round_trip({});
}

// The complaint about a block that was encoded.
std::string complaint(const BlockPlanes& block) {
  auto decoded = std::make_unique<BlockPlanes>();
  const char* wrong = BlockDecoder().decode(BlockEncoder().encode(block), *decoded);
  return wrong == nullptr ? "" : wrong;
}

TEST(BlockCodec, RefusesADistanceThatIsNotANumberAndNegativeWeights) {
  auto block = std::make_unique<BlockPlanes>();
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

TEST(BlockCodec, RefusesVotesThatCannotBe) {
  auto block = std::make_unique<BlockPlanes>();
  block->weight[7] = 1;
  for (const float sum : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0F}) {
    block->vote_sum[7] = sum;
    EXPECT_NE(complaint(*block), "") << sum;
  }
  block->vote_sum[7] = 2;
  block->label_weight[7] = 2;
  EXPECT_EQ(complaint(*block), "");
  block->label_weight[7] = 2.01F;
  EXPECT_EQ(complaint(*block), "a label weighs more than all votes");
}

TEST(BlockCodec, VotesThatAllAgreedOrWereAllFromEveryPixelCostNothing) {
  std::mt19937 random(6);
  auto block = mapped_block(random);
  block->vote_sum = block->label_weight = block->weight;
  const std::size_t same = BlockEncoder().encode(*block).size();
  for (std::size_t v = 0; v < kBlockVoxels; ++v) block->vote_sum[v] = block->label_weight[v] = 0.3F * block->weight[v];
  const std::size_t agreed = BlockEncoder().encode(*block).size();
  for (std::size_t v = 0; v < kBlockVoxels; ++v) block->label_weight[v] = 0.7F * block->vote_sum[v];
  const std::size_t neither = BlockEncoder().encode(*block).size();
  expect_round_trip(*block);
  EXPECT_LT(agreed - same, neither - agreed + 100) << "one of two numbers";
  block->vote_sum.fill(0);
  block->label_weight.fill(0);
  EXPECT_LT(same, BlockEncoder().encode(*block).size() + 40);
}

TEST(BlockCodec, RefusesWhatIsCutOffAndSurvivesWhatIsChanged) {
  std::mt19937 random(5);
  const Bytes good = BlockEncoder().encode(*mapped_block(random));
  auto block = std::make_unique<BlockPlanes>();
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
  auto block = std::make_unique<BlockPlanes>();
  EXPECT_STREQ(BlockDecoder().decode(bomb, *block), "its voxels cannot be decompressed");
}

}  // namespace
}  // namespace panoptic
