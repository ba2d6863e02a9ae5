// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/flat_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace panoptic {
namespace {

const FlatGrid kGrid{{-1, 2}, 0.1, 40, 30};

CellSet random_set(double share, unsigned seed) {
  std::mt19937 random(seed);
  CellSet set(kGrid.size(), 0);
  for (char& cell : set) cell = std::uniform_real_distribution<double>(0, 1)(random) < share ? 1 : 0;
  return set;
}

CellSet rectangle(int x0, int y0, int x1, int y1) {
  CellSet set(kGrid.size(), 0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) set[kGrid.number(x, y)] = 1;
  }
  return set;
}

TEST(FlatGrid, EveryCellHoldsItsMiddle) {
  for (std::size_t cell = 0; cell < kGrid.size(); ++cell) EXPECT_EQ(kGrid.cell_at(kGrid.middle(cell)), cell);
  EXPECT_FALSE(kGrid.cell_at({-1.01, 3}));
  EXPECT_FALSE(kGrid.cell_at({0, 5.01}));
}

TEST(FlatGrid, HugeAreasGetLargerCells) {
  const FlatGrid grid = grid_over(Eigen::AlignedBox2d(Vec2d(0, 0), Vec2d(1e6, 1e6)), 0.05, 2);
  EXPECT_LT(grid.size(), 17'000'000U);
  EXPECT_TRUE(grid.cell_at({999'999, 999'999}));
}

TEST(FlatGrid, ShrinkingAgreesWithEveryDistance) {
  for (const double share : {0.5, 0.95, 0.999}) {
    const CellSet set = random_set(share, 3);
    const CellSet fast = shrunk(kGrid, set, 0.25);
    for (std::size_t cell = 0; cell < kGrid.size(); ++cell) {
      bool is_far = true;
      for (std::size_t other = 0; other < kGrid.size(); ++other) {
        if (set[other] == 0 && (kGrid.middle(other) - kGrid.middle(cell)).norm() <= 0.25 + 1e-9) is_far = false;
      }
      ASSERT_EQ(fast[cell] != 0, is_far) << cell;
    }
  }
}

TEST(FlatGrid, PartsAreConnectedAndApart) {
  const CellSet set = random_set(0.5, 9);
  const CellParts parts = connected_parts(kGrid, set);
  for (int y = 0; y < kGrid.height; ++y) {
    for (int x = 0; x < kGrid.width; ++x) {
      const std::size_t cell = kGrid.number(x, y);
      EXPECT_EQ(parts[cell] != 0, set[cell] != 0);
      if (x + 1 == kGrid.width || set[cell] == 0 || set[cell + 1] == 0) continue;
      EXPECT_EQ(parts[cell], parts[cell + 1]);
    }
  }
  const CellParts two = connected_parts(kGrid, [] {
    CellSet set_of_two = rectangle(2, 2, 5, 5);
    const CellSet more = rectangle(5, 5, 8, 8);  // touches at a corner
    for (std::size_t i = 0; i < more.size(); ++i) set_of_two[i] = static_cast<char>(set_of_two[i] | more[i]);
    return set_of_two;
  }());
  EXPECT_EQ(*std::max_element(two.begin(), two.end()), 2);
}

TEST(FlatGrid, AnOutlineEnclosesItsCells) {
  CellSet ring = rectangle(4, 5, 20, 25);
  for (int y = 10; y < 15; ++y) {
    for (int x = 8; x < 12; ++x) ring[kGrid.number(x, y)] = 0;  // a hole, which the outer edge does not know
  }
  ring[kGrid.number(20, 7)] = 1;
  const Polygon edge = outline(kGrid, CellParts(ring.begin(), ring.end()), 1);
  EXPECT_EQ(edge.size(), 8U);
  EXPECT_NEAR(signed_area(edge), 1.6 * 2.0 + 0.01, 1e-9);
  for (std::size_t cell = 0; cell < kGrid.size(); ++cell) {
    EXPECT_TRUE(ring[cell] == 0 || contains(edge, kGrid.middle(cell)));
  }
  EXPECT_TRUE(outline(kGrid, CellParts(kGrid.size(), 0), 1).empty());
}

TEST(FlatGrid, OutlinesOfRandomSetsHaveTheAreaOfTheirCellsAndHoles) {
  for (unsigned seed = 1; seed < 20; ++seed) {
    const CellParts parts = connected_parts(kGrid, random_set(0.6, seed));
    const Polygon edge = outline(kGrid, parts, 1);
    std::size_t inside = 0;
    for (std::size_t cell = 0; cell < kGrid.size(); ++cell) inside += contains(edge, kGrid.middle(cell)) ? 1 : 0;
    EXPECT_NEAR(signed_area(edge), static_cast<double>(inside) * 0.01, 1e-9);
  }
}

TEST(FlatGrid, GrowingStaysWithinTheSet) {
  const CellSet set = rectangle(2, 2, 30, 6);
  CellParts parts(kGrid.size(), 0);
  parts[kGrid.number(2, 2)] = 1;
  parts[kGrid.number(29, 5)] = 2;
  grow_within(kGrid, set, parts);
  for (std::size_t cell = 0; cell < kGrid.size(); ++cell) EXPECT_EQ(parts[cell] != 0, set[cell] != 0);
  EXPECT_EQ(parts[kGrid.number(10, 4)], 1);
  EXPECT_EQ(parts[kGrid.number(25, 4)], 2);
}

TEST(FlatGrid, APolygonCoversTheCellsWithTheirMiddleInIt) {
  const Polygon triangle = {{-0.5, 2.5}, {1.5, 2.6}, {0.2, 4.1}};
  CellSet set(kGrid.size(), 0);
  add_polygon(kGrid, triangle, set);
  for (std::size_t cell = 0; cell < kGrid.size(); ++cell) EXPECT_EQ(set[cell] != 0, contains(triangle, kGrid.middle(cell)));
}

}  // namespace
}  // namespace panoptic
