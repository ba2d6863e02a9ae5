// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/sight_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <utility>

namespace panoptic {
namespace {

// The definition: tiles of 8 x 8 pixels, one by one.
TEST(SightTiles, AgreeWithTheirDefinition) {
  std::mt19937 random(3);
  for (int round = 0; round < 40; ++round) {
    const int width = 1 + static_cast<int>(random() % 150);
    const int height = 1 + static_cast<int>(random() % 150);
    std::vector<float> depth(static_cast<std::size_t>(width * height));
    for (float& z : depth) z = random() % 300 == 0 ? 0.0F : 1 + static_cast<float>(random() % 1000) * 1e-2F;
    SightTiles tiles;
    tiles.build(depth.data(), width, height);
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    struct Tile {
      float certain = kInfinity;
      float nearest = kInfinity;
      int missing = 0;
      int pixels = 0;
    };
    const auto tile_at = [&](int column, int row) {
      Tile tile;
      for (int v = 8 * row; v < std::min(height, 8 * row + 8); ++v) {
        for (int u = 8 * column; u < std::min(width, 8 * column + 8); ++u) {
          const float z = depth[static_cast<std::size_t>(v * width + u)];
          tile.certain = std::min(tile.certain, z);
          if (z > 0) tile.nearest = std::min(tile.nearest, z);
          tile.missing += z > 0 ? 0 : 1;
          ++tile.pixels;
        }
      }
      return tile;
    };
    const auto two_below = [&](int end) {
      const int a = static_cast<int>(random() % static_cast<unsigned>(end));
      const int b = static_cast<int>(random() % static_cast<unsigned>(end));
      return std::pair(std::min(a, b), std::max(a, b));
    };
    for (int k = 0; k < 30; ++k) {
      const auto [u0, u1] = two_below(width);
      const auto [v0, v1] = two_below(height);
      Tile all;
      float farthest = 0;
      for (int row = v0 / 8; row <= v1 / 8; ++row) {
        for (int column = u0 / 8; column <= u1 / 8; ++column) {
          const Tile tile = tile_at(column, row);
          all.certain = std::min(all.certain, tile.certain);
          all.nearest = std::min(all.nearest, tile.nearest);
          all.missing += tile.missing;
          all.pixels += tile.pixels;
          if (tile.nearest < kInfinity) farthest = std::max(farthest, tile.nearest);
        }
      }
      const PixelArea pixels{u0, u1, v0, v1};
      ASSERT_EQ(tiles.certain_m(pixels), all.certain);
      ASSERT_EQ(tiles.nearest_m(pixels), all.nearest);
      ASSERT_EQ(tiles.farthest_m(pixels), farthest);
      ASSERT_FLOAT_EQ(tiles.missing(pixels), static_cast<float>(all.missing) / static_cast<float>(all.pixels));
    }
  }
}

}  // namespace
}  // namespace panoptic
