// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/map_alignment.h"

#include <gtest/gtest.h>

#include <cmath>

namespace panoptic {
namespace {

Pose turned(double yaw, const Vec3d& shift) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(yaw, Vec3d::UnitZ()).toRotationMatrix();
  pose.translation() = shift;
  return pose;
}

TEST(PosesByConstellations, ThreeObjectsOfManyTell) {
  const std::vector<Landmark> a = {{ClassId{3}, {0, 0, 0.5}},
                                   {ClassId{4}, {2, 0.3, 0.7}},
                                   {ClassId{3}, {1, 3, 0.5}},
                                   {ClassId{5}, {4, 4, 0}},
                                   {ClassId{6}, {-2, 1, 1}}};
  const Pose a_from_b = turned(2, {5, -1, 0.2});
  std::vector<Landmark> b;
  for (std::size_t i = 0; i < 3; ++i) b.push_back({a[i].class_id, a_from_b.inverse() * a[i].at});
  b.push_back({ClassId{5}, {9, 9, 0}});
  const std::vector<Pose> poses = poses_by_constellations(a, b, 1);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_LT((poses[0].translation() - a_from_b.translation()).norm(), 1e-9);
  EXPECT_LT((poses[0].linear() - a_from_b.linear()).norm(), 1e-9);
}

TEST(PosesByConstellations, OneObjectTellsNothing) {
  EXPECT_TRUE(poses_by_constellations({{ClassId{3}, {0, 0, 0}}}, {{ClassId{3}, {1, 1, 0}}}, 5).empty());
  EXPECT_TRUE(poses_by_constellations({}, {}, 5).empty());
}

// Points every 10 cm on a face of 2 m by 2 m.
void add_face(const Vec3d& corner, const Vec3d& u, const Vec3d& v, std::vector<PlacedNormal>& points) {
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) points.push_back({corner + 0.1 * i * u + 0.1 * j * v, u.cross(v)});
  }
}

std::vector<PlacedNormal> moved(std::vector<PlacedNormal> points, const Pose& pose) {
  for (PlacedNormal& p : points) p = {pose * p.at, pose.linear() * p.normal};
  return points;
}

TEST(Fitted, ACornerComesToLieOnItself) {
  std::vector<PlacedNormal> corner;
  add_face({0, 0, 0}, Vec3d::UnitX(), Vec3d::UnitY(), corner);
  add_face({0, 0, 0}, Vec3d::UnitY(), Vec3d::UnitZ(), corner);
  add_face({0, 0, 0}, Vec3d::UnitZ(), Vec3d::UnitX(), corner);
  const Pose a_from_b = turned(0.1, {0.1, -0.15, 0.05});
  const auto b = moved(corner, a_from_b.inverse());
  const SurfaceFit fit = fitted(FitTarget(corner), 0.5, b, Pose::Identity(), 20);
  EXPECT_LT((fit.a_from_b.translation() - a_from_b.translation()).norm(), 1e-3);
  EXPECT_LT((fit.a_from_b.linear() - a_from_b.linear()).norm(), 1e-3);
  EXPECT_GT(fit.least_hold, 0.02);
}

TEST(Fitted, AlongABareCorridorNothingHolds) {
  std::vector<PlacedNormal> corridor;
  add_face({0, 0, 0}, Vec3d::UnitX(), Vec3d::UnitY(), corridor);
  add_face({0, 0, 0}, Vec3d::UnitZ(), Vec3d::UnitX(), corridor);
  const SurfaceFit fit = fitted(FitTarget(corridor), 0.5, corridor, turned(0, {0.05, 0, 0}), 5);
  EXPECT_LT(fit.least_hold, 1e-6);
}

}  // namespace
}  // namespace panoptic
