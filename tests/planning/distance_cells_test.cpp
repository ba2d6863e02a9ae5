// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/distance_cells.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "panoptic/parallel.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

constexpr int kReach = 9;
constexpr int kSide = 22;

// The squared distance to the nearest member, by looking at all of them.
std::uint16_t nearest_squared(const std::vector<Cell>& members, const Cell& cell) {
  int best = kReach * kReach + 1;
  for (const Cell& member : members) best = std::min(best, (member - cell).squaredNorm());
  return best > kReach * kReach ? DistanceCells::kFar : static_cast<std::uint16_t>(best);
}

void expect_exact(const DistanceCells& cells, const std::vector<Cell>& members) {
  const CellBox& box = cells.box();
  std::size_t wrong = 0;
  for (int z = 0; z < box.size.z(); ++z) {
    for (int y = 0; y < box.size.y(); ++y) {
      for (int x = 0; x < box.size.x(); ++x) {
        const Cell cell = box.low + Cell(x, y, z);
        wrong += cells.squared(cell) != nearest_squared(members, cell) ? 1U : 0U;
      }
    }
  }
  EXPECT_EQ(wrong, 0U) << "of " << box.count() << " cells, with " << members.size() << " members";
}

Cell any_cell(std::mt19937& random) {
  const auto coordinate = [&] { return static_cast<int>(random() % kSide) - 5; };
  const int x = coordinate();
  const int y = coordinate();
  return {x, y, coordinate()};
}

TEST(DistanceCells, AreExactAfterEveryChange) {
  std::mt19937 random(3);
  DistanceCells cells(kReach);
  cells.cover({Cell::Constant(-5), Cell::Constant(kSide)});
  std::vector<Cell> members;
  for (int round = 0; round < 12; ++round) {
    for (int i = 0; i < 5; ++i) {
      members.push_back(any_cell(random));
      cells.add(members.back());
    }
    for (int i = 0; i < 3 && round > 2; ++i) {
      const std::size_t gone = random() % members.size();
      cells.remove(members[gone]);
      members.erase(members.begin() + static_cast<std::ptrdiff_t>(gone));
    }
    cells.update();
    expect_exact(cells, members);
  }
}

TEST(DistanceCells, AreExactAfterTheBoxHasGrown) {
  DistanceCells cells(kReach);
  std::vector<Cell> members = {{0, 0, 0}};
  cells.cover({Cell::Zero(), Cell::Ones()});
  cells.add(members[0]);
  cells.update();
  members.emplace_back(-14, 3, 20);
  cells.cover({members[1], Cell::Ones()});
  cells.add(members[1]);
  cells.update();
  EXPECT_TRUE(cells.box().contains(members[1]));
  expect_exact(cells, members);
}

TEST(DistanceCells, ACellThatWasAddedTwiceStaysUntilItIsRemovedTwice) {
  DistanceCells cells(kReach);
  cells.cover({Cell::Zero(), Cell::Ones()});
  cells.add(Cell::Zero());
  cells.add(Cell::Zero());
  cells.remove(Cell::Zero());
  cells.update();
  EXPECT_EQ(cells.squared(Cell::Zero()), 0);
  cells.remove(Cell::Zero());
  cells.update();
  EXPECT_EQ(cells.squared(Cell::Zero()), DistanceCells::kFar);
}

TEST(DistanceCells, OnlyCellsWithinReachOfAChangeChange) {
  DistanceCells cells(3);
  cells.cover({Cell::Zero(), Cell::Constant(40)});
  cells.add(Cell::Constant(10));
  cells.update();
  EXPECT_EQ(cells.update(), 0U);
  cells.add(Cell::Constant(30));
  EXPECT_EQ(cells.update(), 123U);  // the cells of a ball of radius 3
}

TEST(DistanceCells, ABoxBeyondTheMemoryIsRefused) {
  DistanceCells cells(kReach);
  EXPECT_THAT(test::error_of([&] { cells.cover({Cell::Zero(), Cell::Constant(100000)}); }), testing::HasSubstr("more than"));
}

}  // namespace
}  // namespace panoptic
