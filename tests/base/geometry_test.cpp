// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/geometry.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace panoptic {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Camera kCamera{640, 480, 577.0, 578.0, 318.5, 241.5};

Pose random_pose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized().toRotationMatrix();
  pose.translation() = Vec3d(normal(random), normal(random), normal(random)) * 5;
  return pose;
}

// The definition of the pinhole camera, the other way round.
Eigen::Vector2d project(const Camera& c, const Vec3d& p) { return {c.fx * p.x() / p.z() + c.cx, c.fy * p.y() / p.z() + c.cy}; }

TEST(BackProject, IsTheInverseOfProjection) {
  for (const auto& [u, v, z] : {std::tuple{0.0, 0.0, 0.5}, {639.0, 479.0, 4.0}, {318.5, 241.5, 1.0}, {-0.5, 479.5, 9.0}}) {
    const Vec3d point = back_project(kCamera, u, v, z);
    EXPECT_DOUBLE_EQ(point.z(), z);  // depth is planar, not along the ray
    EXPECT_TRUE(project(kCamera, point).isApprox(Eigen::Vector2d(u, v), 1e-12));
  }
}

TEST(Resized, KeepsTheRaysThroughCornersAndEdges) {
  const Camera half = resized(kCamera, 320, 160);
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 160);
  // The image spans [-0.5, size - 0.5]: its borders see the same ray before and after.
  for (const auto& [u, v, half_u, half_v] :
       {std::tuple{-0.5, -0.5, -0.5, -0.5}, {639.5, 479.5, 319.5, 159.5}, {319.5, 239.5, 159.5, 79.5}}) {
    EXPECT_TRUE(back_project(kCamera, u, v, 1).isApprox(back_project(half, half_u, half_v, 1), 1e-12)) << u << " " << v;
  }
}

TEST(Resized, ToTheSameSizeChangesNothing) { EXPECT_EQ(resized(kCamera, 640, 480), kCamera); }

TEST(Resized, AverageOfTwoPixelsLiesBetweenThem) {
  const Camera half = resized(kCamera, 320, 240);
  const Vec3d between = (back_project(kCamera, 10, 20, 1) + back_project(kCamera, 11, 21, 1)) / 2;
  EXPECT_TRUE(back_project(half, 5, 10, 1).isApprox(between, 1e-12));
}

TEST(Rigid, LeavesARigidPoseAsItIs) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = random_pose(random);
    ASSERT_TRUE(rigid(pose.matrix()).matrix().isApprox(pose.matrix(), 1e-12));
  }
}

TEST(Rigid, RepairsARoundedMatrix) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> error(-5e-4, 5e-4);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = random_pose(random);
    Eigen::Matrix4d rounded = pose.matrix();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) rounded(row, column) += error(random);
    }
    const Pose repaired = rigid(rounded);
    ASSERT_TRUE(is_rigid(repaired, 1e-12));
    ASSERT_TRUE(repaired.matrix().isApprox(pose.matrix(), 2e-3));
    // No rigid pose is closer than the one found; the original is one of the others.
    ASSERT_LE((repaired.linear() - rounded.topLeftCorner<3, 3>()).norm(),
              (pose.linear() - rounded.topLeftCorner<3, 3>()).norm() + 1e-12);
  }
}

TEST(Rigid, NeverGivesAMirrorImage) {
  Eigen::Matrix4d mirrored = Eigen::Matrix4d::Identity();
  mirrored(2, 2) = -0.01;
  EXPECT_TRUE(is_rigid(rigid(mirrored), 1e-9));
}

TEST(Rigid, KeepsTheTranslation) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topRightCorner<3, 1>() = Vec3d(1, -2, 3);
  EXPECT_EQ(rigid(matrix).translation(), Vec3d(1, -2, 3));
}

TEST(Rigid, DoesNotHideNaNOrInfinity) {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
        matrix(row, column) = bad;
        EXPECT_FALSE(is_rigid(rigid(matrix))) << row << " " << column;
        EXPECT_FALSE(is_finite(rigid(matrix))) << row << " " << column;
      }
    }
  }
}

TEST(IsRigid, RefusesScaleShearAndMirror) {
  EXPECT_TRUE(is_rigid(Pose::Identity()));
  Pose pose = Pose::Identity();
  pose.linear() *= 1.01;
  EXPECT_FALSE(is_rigid(pose));
  EXPECT_TRUE(is_rigid(pose, 0.05));
  pose = Pose::Identity();
  pose.linear()(0, 1) = 0.1;
  EXPECT_FALSE(is_rigid(pose));
  pose = Pose::Identity();
  pose.linear()(1, 1) = -1;  // orthonormal, but determinant -1
  EXPECT_FALSE(is_rigid(pose));
  pose.linear().setZero();
  EXPECT_FALSE(is_rigid(pose));
}

}  // namespace
}  // namespace panoptic
