// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/support_planes.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

#include "tests/block_planes.h"
#include "tests/fusion/small_maps.h"

namespace panoptic {
namespace {

using test::add_solids;
using test::pid;
using test::solid_box;
using test::solid_ground;

constexpr double kDegree = std::numbers::pi / 180;
const Vec3d kUp = Vec3d::UnitZ();

Vec3d tilted(double degrees) { return {std::sin(degrees * kDegree), 0, std::cos(degrees * kDegree)}; }

// A ground of this slope with a box on it.
VoxelMap ground_with_box(const Vec3d& up) {
  VoxelMap map{MapOptions{}};
  add_solids(map, {solid_ground(up, 0.5, pid(1)), solid_box({0.2, 0.2, 0.3}, {0.5, 0.5, 1.1}, pid(2))}, {-0.8, -0.8, 0.1},
             {0.8, 0.8, 1.3});
  return map;
}

// The top, 0.7 m high, and sides of a table.
VoxelMap table() {
  VoxelMap map{MapOptions{}};
  add_solids(map, {solid_box({-0.6, -0.4, 0.55}, {0.6, 0.4, 0.7}, pid(1)), solid_box({0, 0, 0.7}, {0.2, 0.2, 0.9}, pid(1))},
             {-0.9, -0.9, 0.5}, {0.9, 0.9, 1.0});
  return map;
}

std::vector<std::uint32_t> all_of(const SurfaceVoxels& surface) {
  std::vector<std::uint32_t> all(surface.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

TEST(Normals, PointOutOfThePlaneAlsoAtTheBordersOfBlocks) {
  for (const double degrees : {0.0, 7.0, 40.0}) {
    VoxelMap map{MapOptions{}};
    const Vec3d up = tilted(degrees);
    add_solids(map, {solid_ground(up, 0.01, pid(1))}, Vec3d::Constant(-0.6), Vec3d::Constant(0.6));
    const SurfaceVoxels surface(map);
    std::size_t known = 0;
    for (std::uint32_t i = 0; i < surface.size(); ++i) {
      const Vec3d n = normal_of(map, surface[i]);
      if (n.isZero()) continue;
      ++known;
      ASSERT_GT(n.dot(up), 0.999) << degrees << " degrees";
      ASSERT_NEAR(n.norm(), 1, 1e-9);
    }
    EXPECT_GT(known, surface.size() * 8 / 10);
  }
}

TEST(Normals, AreZeroWhereANeighbourWasNotObserved) {
  VoxelMap map{MapOptions{}};
  add_solids(map, {solid_ground(kUp, 0.01, pid(1))}, Vec3d::Constant(-0.3), Vec3d::Constant(0.3));
  const SurfaceVoxels surface(map);
  std::uint32_t i = 0;
  while (surface[i].voxel % kBlockSide == 0 || normal_of(map, surface[i]).isZero()) ++i;
  map.block(surface[i].slot).set(surface[i].voxel - 1, {});
  EXPECT_TRUE(normal_of(map, surface[i]).isZero());
}

TEST(Normals, OfAFlatFieldAreZeroAndNotNan) {
  VoxelMap map{MapOptions{}};
  test::BlockEdit(map.block(map.allocate({0, 0, 0})))->weight.fill(1);
  const SurfaceVoxels surface(map);
  ASSERT_EQ(surface.size(), static_cast<std::size_t>(kBlockVoxels));
  for (std::uint32_t i = 0; i < surface.size(); ++i) ASSERT_TRUE(normal_of(map, surface[i]).isZero());
  EXPECT_EQ(vertical(map, surface, kUp), kUp);
  EXPECT_FALSE(fit_top(map, surface, all_of(surface), kUp));
}

TEST(Vertical, IsTheNormalOfTheFloorNearARoughGuess) {
  for (const double degrees : {0.0, 5.0, 15.0}) {
    const VoxelMap map = ground_with_box(tilted(degrees));
    const Vec3d found = vertical(map, SurfaceVoxels(map), kUp);
    EXPECT_GT(found.dot(tilted(degrees)), std::cos(1.5 * kDegree)) << degrees << " degrees";
    EXPECT_NEAR(found.norm(), 1, 1e-9);
  }
}

TEST(Vertical, StaysAsGuessedWhereNothingIsLevel) {
  VoxelMap map{MapOptions{}};
  EXPECT_EQ(vertical(map, SurfaceVoxels(map), kUp), kUp);
  add_solids(map, {solid_ground(Vec3d::UnitX(), 0, pid(1))}, Vec3d::Constant(-0.3), Vec3d::Constant(0.3));
  EXPECT_EQ(vertical(map, SurfaceVoxels(map), kUp), kUp);
}

TEST(FitTop, FindsTheHeightOfATableWithAThingOnIt) {
  const VoxelMap map = table();
  const SurfaceVoxels surface(map);
  const auto top = fit_top(map, surface, all_of(surface), kUp);
  ASSERT_TRUE(top);
  for (const double x : {-0.5, 0.0, 0.5}) {
    for (const double y : {-0.3, 0.3}) {
      EXPECT_NEAR(top->height_above({x, y, 0.7}), 0, 0.003);
      EXPECT_NEAR(top->height_above({x, y, 0.8}), 0.1, 0.003);
      EXPECT_TRUE(top->below({x, y, 0.8}));
    }
  }
}

TEST(FitTop, KnowsWhereTheTableEnds) {
  const VoxelMap map = table();
  const SurfaceVoxels surface(map);
  const auto top = fit_top(map, surface, all_of(surface), kUp);
  ASSERT_TRUE(top);
  EXPECT_TRUE(top->below({0.59, 0.39, 2}));
  for (const Vec3d& outside : {Vec3d(0.8, 0, 0.8), Vec3d(-0.8, 0, 0.8), Vec3d(0, 0.6, 0.8), Vec3d(0, -0.6, 0.8)}) {
    EXPECT_FALSE(top->below(outside)) << outside.transpose();
  }
}

// Recordings drift: tables are not quite level.
TEST(FitTop, FollowsASlope) {
  const VoxelMap map = ground_with_box(tilted(4));
  const SurfaceVoxels surface(map);
  const auto top = fit_top(map, surface, all_of(surface), kUp);
  ASSERT_TRUE(top);
  for (const double x : {-0.6, 0.0, 0.6}) {
    const double z = (0.5 - x * tilted(4).x()) / tilted(4).z();
    EXPECT_NEAR(top->height_above({x, 0, z}), 0, 0.005);
  }
}

TEST(FitTop, HasNoneForWallsAndForTooFewPoints) {
  VoxelMap map{MapOptions{}};
  add_solids(map, {solid_ground(Vec3d::UnitX(), 0, pid(1))}, Vec3d::Constant(-0.6), Vec3d::Constant(0.6));
  const SurfaceVoxels wall(map);
  EXPECT_FALSE(fit_top(map, wall, all_of(wall), kUp));
  const VoxelMap flat = table();
  const SurfaceVoxels surface(flat);
  const std::vector<std::uint32_t> all = all_of(surface);
  EXPECT_FALSE(fit_top(flat, surface, std::span(all).first(100), kUp));
  EXPECT_FALSE(fit_top(flat, surface, {}, kUp));
}

// Level points in one line do not say how a plane tilts across it.
TEST(FitTop, OfALedgeOneVoxelWideIsNoneOrSane) {
  VoxelMap map{MapOptions{}};
  add_solids(map, {solid_ground(kUp, 0.01, pid(1))}, {-2.5, -0.2, -0.2}, {2.5, 0.2, 0.2});
  const SurfaceVoxels surface(map);
  std::vector<std::uint32_t> ledge;
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    if (surface[i].at[1] == 0 && surface[i].at[2] == 0) ledge.push_back(i);
  }
  ASSERT_GT(ledge.size(), 200U);
  const auto top = fit_top(map, surface, ledge, kUp);
  if (!top) return;
  EXPECT_NEAR(top->height_above({1, 0.2, 0.01}), 0, 0.05);
  EXPECT_NEAR(top->height_above({-1, -0.2, 0.01}), 0, 0.05);
}

TEST(StandsOn, IsAboveTheTopButNotHighAboveAndWhereSaidOverIt) {
  const VoxelMap map = table();
  const SurfaceVoxels surface(map);
  const auto top = fit_top(map, surface, all_of(surface), kUp);
  ASSERT_TRUE(top);
  EXPECT_FALSE(stands_on(*top, {0, 0, 0.71}, 0.02, false));
  EXPECT_TRUE(stands_on(*top, {0, 0, 0.73}, 0.02, false));
  EXPECT_TRUE(stands_on(*top, {0, 0, 1.25}, 0.02, true));
  EXPECT_FALSE(stands_on(*top, {0, 0, 1.35}, 0.02, true)) << "lamps hang, they do not stand";
  EXPECT_FALSE(stands_on(*top, {0, 0, 0.5}, 0.02, false));
  EXPECT_TRUE(stands_on(*top, {1.5, 0, 0.8}, 0.02, false));
  EXPECT_FALSE(stands_on(*top, {1.5, 0, 0.8}, 0.02, true));
}

}  // namespace
}  // namespace panoptic
