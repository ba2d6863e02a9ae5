// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/distance_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "panoptic/planning/surface_samples.h"
#include "tests/expect_error.h"
#include "tests/planning/furnished.h"

namespace panoptic {
namespace {

const Pose& turned() {
  static const Pose kPose = [] {
    Pose pose = Pose::Identity();
    pose.linear() = (Eigen::AngleAxisd(1.1, Vec3d(1, 2, -0.5).normalized()) * Eigen::AngleAxisd(0.4, Vec3d::UnitZ())).matrix();
    pose.translation() = Vec3d(0.3, -0.2, 0.5);
    return pose;
  }();
  return kPose;
}

UpFrame frame_of(const Pose& world_from_room) {
  UpFrame frame;
  frame.grid_from_world = world_from_room.inverse();
  return frame;
}

// The largest difference between the field and the distance to the nearest sample of the surface, by looking at all of them.
double largest_error_m(const PanopticMap& map, const DistanceField& field) {
  std::vector<Vec3f> samples;
  const Eigen::Isometry3f grid_from_world = field.grid_from_world().cast<float>();
  for (const auto& block : surface_samples(map.voxels)) {
    for (const SurfaceSample& sample : block) samples.push_back(grid_from_world * sample.at_m);
  }
  const DistanceField::Values values = field.values();
  double largest = 0;
  for (std::size_t i = 0; i < values.distance_m.size(); i += 997) {
    if (std::isnan(values.distance_m[i])) continue;
    const auto nx = static_cast<std::size_t>(values.size.x());
    const auto ny = static_cast<std::size_t>(values.size.y());
    const Vec3d cell(static_cast<double>(i % nx), static_cast<double>(i / nx % ny), static_cast<double>(i / nx / ny));
    const Vec3f at = (values.origin_m + cell * field.cell_m()).cast<float>();
    float nearest = std::numeric_limits<float>::infinity();
    for (const Vec3f& sample : samples) nearest = std::min(nearest, (sample - at).squaredNorm());
    const double distance = std::min(field.cap_m(), double{std::sqrt(nearest)});
    largest = std::max(largest, std::abs(std::abs(double{values.distance_m[i]}) - distance));
  }
  return largest;
}

TEST(DistanceField, IsWithinACellOfTheNearestSurface) {
  for (const Pose& pose : {Pose(Pose::Identity()), turned()}) {
    const PanopticMap map = test::furnished_map(pose, 0.05F);
    DistanceField field(frame_of(pose));
    field.update(map);
    EXPECT_LE(largest_error_m(map, field), field.cell_m());
  }
}

void expect_same(const DistanceField& field, const DistanceField& other) {
  const auto a = field.values();
  const auto b = other.values();
  ASSERT_EQ(a.size, b.size);
  for (std::size_t i = 0; i < a.distance_m.size(); ++i) {
    ASSERT_TRUE(a.distance_m[i] == b.distance_m[i] || (std::isnan(a.distance_m[i]) && std::isnan(b.distance_m[i])));
  }
}

TEST(DistanceField, FollowsAChangeAsIfMadeAnew) {
  PanopticMap map = test::furnished_map(Pose::Identity(), 0.05F);
  DistanceField field(frame_of(Pose::Identity()));
  field.update(map);
  map.voxels.begin_epoch();
  const auto without_chair = field.distance_at({0.9, -0.7, 0.5});
  const Slot slot = map.voxels.allocate({1, -1, 0});
  for (int offset = 0; offset < kBlockVoxels; ++offset) {  // the chair's part in this block is gone
    Voxel voxel = map.voxels.block(slot).at(offset);
    if (voxel.weight <= 0) continue;
    voxel.distance = map.voxels.truncation_m();
    map.voxels.block(slot).set(offset, voxel);
  }
  map.voxels.mark_changed(slot);
  field.update(map);
  DistanceField fresh(frame_of(Pose::Identity()));
  fresh.update(map);
  expect_same(field, fresh);
  EXPECT_NE(field.distance_at({0.9, -0.7, 0.5}), without_chair);
}

TEST(DistanceField, FollowsAMapThatWasFusedAnewWithFewerBlocks) {
  PanopticMap map = test::furnished_map(Pose::Identity(), 0.05F);
  DistanceField field(frame_of(Pose::Identity()));
  field.update(map);
  PanopticMap smaller({.voxel_size_m = 0.05F}, map.labels);
  smaller.voxels.restore_epochs(map.voxels.epoch() + 1, {});
  test::add_solids(smaller.voxels, {test::solid_ground(Vec3d::UnitZ(), 0.3, test::kFloorSlot)}, {-1, -1, 0}, {1, 1, 0.7});
  ASSERT_LT(smaller.voxels.block_count(), map.voxels.block_count());
  map.voxels = std::move(smaller.voxels);
  field.update(map);
  DistanceField fresh(frame_of(Pose::Identity()));
  fresh.update(map);
  expect_same(field, fresh);
  EXPECT_NEAR(field.distance_m({0, 0, 0.5}).value(), 0.2, 0.05);
}

TEST(DistanceField, IsNegativeBehindASurfaceAndUnknownWhereNothingWasSeen) {
  const PanopticMap map = test::furnished_map();
  DistanceField field(frame_of(Pose::Identity()));
  field.update(map);
  EXPECT_NEAR(field.distance_m({-1, -0.6, 0.5}).value(), 0.5, 0.05);
  EXPECT_LT(field.distance_m({0.1, -0.6, 0.5}).value(), 0);
  EXPECT_FALSE(field.distance_m({50, 0, 0}).has_value());
  EXPECT_FALSE(field.distance_at({std::numeric_limits<double>::quiet_NaN(), 0, 0}).has_value());
}

TEST(DistanceField, TheGradientLeadsAwayFromTheNearestSurface) {
  const PanopticMap map = test::furnished_map();
  DistanceField field(frame_of(Pose::Identity()));
  field.update(map);
  EXPECT_GT(field.gradient({-1, 0, 0.3}).value().z(), 0.95);
  EXPECT_GT(field.gradient({-1.8, 0, 0.7}).value().x(), 0.95);
  EXPECT_LT(field.gradient({-1, 1.3, 0.7}).value().y(), -0.95);
}

TEST(DistanceField, AbsurdOptionsAreRefused) {
  const auto error = [](const DistanceFieldOptions& options) { return test::error_of([&] { DistanceField({}, options); }); };
  EXPECT_THAT(error({.cell_m = std::numeric_limits<double>::quiet_NaN()}), testing::HasSubstr("0.01 to 1"));
  EXPECT_THAT(error({.cap_m = 1e9}), testing::HasSubstr("cells"));
}

}  // namespace
}  // namespace panoptic
