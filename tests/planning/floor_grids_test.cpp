// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/floor_grids.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/expect_error.h"
#include "tests/planning/furnished.h"

namespace panoptic {
namespace {

const PanopticMap& rooms() {
  static const PanopticMap kMap = test::furnished_map();
  return kMap;
}

FloorGrids grids(const std::vector<HeightBand>& bands = {}) { return floor_grids(rooms(), UpFrame(), {}, bands); }

std::size_t index_at(const FloorGrids& grids, double x, double y) {
  const Eigen::Vector2d cell = (Eigen::Vector2d(x, y) - grids.origin_m) / grids.cell_m;
  EXPECT_TRUE((cell.array() >= 0).all() && cell.x() < grids.columns && cell.y() < grids.rows);
  return static_cast<std::size_t>(cell.x()) + static_cast<std::size_t>(grids.columns) * static_cast<std::size_t>(cell.y());
}

TEST(FloorGrids, TellWhereThereIsRoom) {
  const FloorGrids all = grids({{0.3, 0.9}});
  EXPECT_EQ(all.standing.size(), static_cast<std::size_t>(all.rows) * static_cast<std::size_t>(all.columns));
  EXPECT_EQ(all.standing[index_at(all, -1, 0)], Space::kFree);
  EXPECT_EQ(all.standing[index_at(all, 1.12, -0.7)], Space::kOccupied) << "the chair";
  EXPECT_EQ(all.standing[index_at(all, 2.06, 1.6)], Space::kUnknown) << "behind a wall";
  EXPECT_EQ(all.standing[index_at(all, -1.7, -1.1)], Space::kOccupied) << "under the shelf";
  ASSERT_EQ(all.bands.size(), 1U);
  EXPECT_EQ(all.bands[0][index_at(all, -1.7, -1.1)], Space::kFree) << "the band is below the shelf";
}

TEST(FloorGrids, NameWhatIsThere) {
  const FloorGrids all = grids();
  EXPECT_EQ(all.class_at[index_at(all, 1, 0)], ClassId{2});
  EXPECT_EQ(all.class_at[index_at(all, 1.3, -0.7)], ClassId{3});
  EXPECT_EQ(all.is_seen[index_at(all, 1.3, -0.7)], 1);
  EXPECT_EQ(all.is_seen.front(), 0) << "the rim";
  EXPECT_EQ(all.class_at.front(), ClassId::kUnknown);
}

TEST(FloorGrids, AMapWithoutSurfaceHasNoCells) {
  const PanopticMap empty({.voxel_size_m = 0.05F}, rooms().labels);
  const FloorGrids none = floor_grids(empty, UpFrame(), {}, {{0, 1}});
  EXPECT_EQ(none.columns * none.rows, 0);
  EXPECT_TRUE(none.standing.empty() && none.bands.at(0).empty() && none.class_at.empty());
}

TEST(FloorGrids, AbsurdSizesAreRefused) {
  EXPECT_THAT(test::error_of([] { floor_grids(rooms(), UpFrame(), {.height_m = NAN}); }), testing::HasSubstr("height"));
  EXPECT_THAT(test::error_of([] { grids({{1, 0.5}}); }), testing::HasSubstr("band"));
}

}  // namespace
}  // namespace panoptic
