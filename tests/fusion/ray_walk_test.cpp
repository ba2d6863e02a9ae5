// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/ray_walk.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <vector>

#include "panoptic/base/floor.h"
#include "tests/fusion/naive_fusion.h"

namespace panoptic {
namespace {

using Cell = std::array<std::int32_t, 3>;

std::vector<Cell> cells_between(const Vec3f& start, const Vec3f& end) {
  std::vector<Cell> cells;
  test::walk_cells(start, end, [&](std::int32_t x, std::int32_t y, std::int32_t z) { cells.push_back({x, y, z}); });
  return cells;
}

// Numbers of a known algorithm in [-reach, reach).
class Numbers {
 public:
  float next(float reach) {
    state_ = state_ * 1664525U + 1013904223U;
    return (static_cast<float>(state_ >> 8U) / 8388608.0F - 1.0F) * reach;
  }
  Vec3f point(float reach) {
    const float x = next(reach);
    const float y = next(reach);
    return {x, y, next(reach)};
  }

 private:
  std::uint32_t state_ = 7;
};

TEST(RayWalk, GoesFromTheFirstCellToTheLastThroughNeighbours) {
  Numbers numbers;
  for (int i = 0; i < 2000; ++i) {
    const Vec3f start = numbers.point(50);
    const Vec3f end = start + numbers.point(12);
    const std::vector<Cell> cells = cells_between(start, end);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(cells.front()[a], floor_to_int(start[static_cast<int>(a)]));
      EXPECT_NEAR(cells.back()[a], floor_to_int(end[static_cast<int>(a)]), 1) << "rounding may swap the last steps";
    }
    for (std::size_t k = 1; k < cells.size(); ++k) {
      int moved = 0;
      for (std::size_t a = 0; a < 3; ++a) moved += std::abs(cells[k][a] - cells[k - 1][a]);
      ASSERT_EQ(moved, 1);
    }
  }
}

TEST(RayWalk, AlongAnAxisVisitsEveryCellOnce) {
  EXPECT_EQ(cells_between({0.5F, 0.5F, 0.5F}, {3.5F, 0.5F, 0.5F}),
            (std::vector<Cell>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}));
  EXPECT_EQ(cells_between({0.5F, 0.5F, 0.5F}, {0.5F, -1.5F, 0.5F}), (std::vector<Cell>{{0, 0, 0}, {0, -1, 0}, {0, -2, 0}}));
  EXPECT_EQ(cells_between({0.5F, 0.5F, 0.5F}, {0.5F, 0.5F, 0.5F}), (std::vector<Cell>{{0, 0, 0}}));
}

Cell block_of(const Cell& cell) { return {cell[0] >> 4, cell[1] >> 4, cell[2] >> 4}; }

TEST(RayWalk, SixteenTogetherVisitTheCellsOfEachAlone) {
  Numbers numbers;
  const auto walks = std::make_unique<CellWalks>();
  for (int round = 0; round < 200; ++round) {
    for (std::size_t lane = 0; lane < kWalkLanes; ++lane) {
      const Vec3f start = numbers.point(100);
      const Vec3f apart = numbers.point(lane % 4 == 0 ? 0.4F : 30);
      for (int a = 0; a < 3; ++a) {
        walks->start[a][lane] = start[a];
        walks->end[a][lane] = start[a] + (lane % 5 == 0 && a == 1 ? 0.0F : apart[a]);
      }
    }
    walk_together(*walks);
    for (std::size_t lane = 0; lane < kWalkLanes; ++lane) {
      const auto alone = cells_between({walks->start[0][lane], walks->start[1][lane], walks->start[2][lane]},
                                       {walks->end[0][lane], walks->end[1][lane], walks->end[2][lane]});
      ASSERT_EQ(static_cast<std::size_t>(walks->count[lane]), alone.size());
      for (std::size_t i = 0; i < alone.size(); ++i) {
        const Cell together{walks->cell[0][i][lane], walks->cell[1][i][lane], walks->cell[2][i][lane]};
        ASSERT_EQ(together, alone[i]) << "lane " << lane << ", cell " << i;
        const auto [x, y, z] = alone[i];
        ASSERT_EQ(walks->offset[i][lane], (x & 15) + 16 * (y & 15) + 256 * (z & 15)) << "lane " << lane << ", cell " << i;
        const bool left = i > 0 && block_of(alone[i]) != block_of(alone[i - 1]);
        ASSERT_EQ((walks->borders[i / 32][lane] >> i % 32 & 1U) != 0, left) << "lane " << lane << ", cell " << i;
      }
    }
  }
}

}  // namespace
}  // namespace panoptic
