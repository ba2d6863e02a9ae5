// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/up_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/expect_error.h"
#include "tests/fusion/scenes.h"
#include "tests/fusion/small_maps.h"

namespace panoptic {
namespace {

using test::pid;
using testing::HasSubstr;

constexpr LabelSlot kWall = pid(1);
constexpr LabelSlot kFloor = pid(2);
constexpr LabelSlot kNothing = pid(0);

PanopticMap empty_map() { return {MapOptions{.voxel_size_m = 0.05F}, test::test_labels()}; }

// A floor at this height along `up`, and a wall and a large table that stand on it.
PanopticMap room(const Vec3d& up, double height_m, LabelSlot floor, LabelSlot table) {
  PanopticMap map = empty_map();
  const Eigen::Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), up).toRotationMatrix();
  const auto turned = [&](const Vec3d& low, const Vec3d& high, LabelSlot label) {
    const test::Solid box = test::solid_box(low, high, label);
    return test::Solid{[=](const Vec3d& p) { return box.distance_m(turn.transpose() * p - Vec3d(0, 0, height_m)); }, label};
  };
  const std::vector<test::Solid> solids = {test::solid_ground(up, height_m, floor), turned({-1.2, 1, -1}, {1.2, 1.5, 3}, kWall),
                                           turned({-0.5, -0.5, 0.6}, {0.6, 0.6, 0.7}, table)};
  test::add_solids(map.voxels, solids, Vec3d::Constant(-1.6), Vec3d::Constant(1.6));
  return map;
}

TEST(UpFrame, PutsAnyFloorAtZero) {
  for (const Vec3d& up : {Vec3d(0, 0, 1), Vec3d(0, -1, 0), Vec3d(1, 0, 0), Vec3d(0, 0, -1), Vec3d(0.3, -0.8, 0.5)}) {
    const Vec3d unit = up.normalized();
    const PanopticMap map = room(unit, -0.3, kFloor, pid(3));
    const UpFrame frame = up_frame(map, unit);
    EXPECT_LT((frame.grid_from_world.linear() * unit - Vec3d::UnitZ()).norm(), 0.01) << up.transpose();
    EXPECT_LT((frame.up() - unit).norm(), 0.01);
    EXPECT_NEAR((frame.grid_from_world * Vec3d(unit * -0.3)).z(), 0, 0.01);
    EXPECT_TRUE(frame.floor_is_labelled);
    EXPECT_GT(frame.floor_area_m2, 3);
    EXPECT_TRUE(is_rigid(frame.grid_from_world, 1e-9));
  }
}

TEST(UpFrame, AHintMayBeThirtyDegreesOff) {
  const PanopticMap map = room(Vec3d::UnitZ(), 0, kFloor, pid(3));
  const UpFrame frame = up_frame(map, Vec3d(0.5, 0, 0.87));
  EXPECT_LT((frame.up() - Vec3d::UnitZ()).norm(), 0.01);
}

TEST(UpFrame, LabelsTellWithoutAHint) {
  const Vec3d up = Vec3d(0.2, 0.9, -0.3).normalized();
  EXPECT_LT((up_frame(room(up, 0.1, kFloor, pid(3))).up() - up).norm(), 0.01);
  EXPECT_THAT(test::error_of([&] { up_frame(room(up, 0.1, kNothing, kNothing)); }), HasSubstr("which way is up"));
}

TEST(UpFrame, WithoutLabelsTheLowestLargeLevelIsTheFloor) {
  const PanopticMap map = room(Vec3d::UnitZ(), -0.2, kNothing, kNothing);
  const UpFrame frame = up_frame(map, Vec3d::UnitZ());
  EXPECT_FALSE(frame.floor_is_labelled);
  EXPECT_NEAR(frame.grid_from_world.translation().z(), 0.2, 0.01);
}

TEST(UpFrame, AnUprightFrameIsNotTurned) {
  const UpFrame frame = up_frame(room(Vec3d::UnitZ(), 0, kFloor, pid(3)), Vec3d::UnitZ());
  EXPECT_LT((frame.grid_from_world.linear() - Eigen::Matrix3d::Identity()).norm(), 0.01);
  EXPECT_EQ(frame.grid_from_world.translation().head<2>().norm(), 0);
}

TEST(UpFrame, AMapWithoutAFloorIsRefused) {
  EXPECT_THAT(test::error_of([] { up_frame(empty_map(), Vec3d::UnitZ()); }), HasSubstr("no surface"));
  PanopticMap wall = empty_map();
  test::add_solids(wall.voxels, {test::solid_ground(Vec3d::UnitX(), 0, kWall)}, Vec3d::Constant(-1), Vec3d::Constant(1));
  EXPECT_THAT(test::error_of([&] { up_frame(wall, Vec3d::UnitZ()); }), HasSubstr("no floor"));
}

}  // namespace
}  // namespace panoptic
