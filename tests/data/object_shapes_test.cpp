// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "panoptic/data/speaker.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;

constexpr auto kChair = static_cast<ClassId>(3);
constexpr auto kFirst = static_cast<PanopticId>(7);
constexpr auto kSecond = static_cast<PanopticId>(9);

void add_vertex(Mesh& mesh, const Vec3d& position, PanopticId id = kFirst, ClassId class_id = kChair) {
  mesh.vertices.push_back({position.cast<float>(), Vec3f::UnitZ(), {}, class_id, id});
}

// One face of a box as a grid of squares, so that its corners get no more weight than its middle.
void add_face(Mesh& mesh, const Vec3d& corner, const Vec3d& a, const Vec3d& b, PanopticId id) {
  constexpr int kSteps = 5;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) add_vertex(mesh, corner + a * i / kSteps + b * j / kSteps, id);
  }
  for (std::uint32_t j = 0; j < kSteps; ++j) {
    for (std::uint32_t i = 0; i < kSteps; ++i) {
      const std::uint32_t v = first + j * (kSteps + 1) + i;
      mesh.triangles.push_back({v, v + 1, v + kSteps + 2});
      mesh.triangles.push_back({v, v + kSteps + 2, v + kSteps + 1});
    }
  }
}

// All six faces of a box of that size around the origin, moved by `pose`.
void add_box(Mesh& mesh, const Vec3d& size, const Pose& pose, PanopticId id = kFirst) {
  const Vec3d corner = pose * (-0.5 * size);
  const Matrix3d edges = pose.linear() * size.asDiagonal();
  for (int k = 0; k < 3; ++k) {
    const Vec3d a = edges.col((k + 1) % 3);
    const Vec3d b = edges.col((k + 2) % 3);
    add_face(mesh, corner, b, a, id);
    add_face(mesh, corner + edges.col(k), a, b, id);
  }
}

Pose turned(const Vec3d& axis, double angle, const Vec3d& at) {
  Pose pose = Pose::Identity();
  pose.linear() = AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  pose.translation() = at;
  return pose;
}

// Every vertex inside, within a rounding error of a float.
void expect_holds_all(const OrientedBox& box, const Mesh& mesh) {
  for (const MeshVertex& vertex : mesh.vertices) {
    const Vec3d local = box.axes.transpose() * (vertex.position.cast<double>() - box.center_m);
    ASSERT_TRUE((local.cwiseAbs().array() <= (0.5 * box.size_m).array() + 1e-5).all()) << vertex.position.transpose();
  }
}

void expect_proper(const OrientedBox& box) {
  EXPECT_TRUE(box.center_m.allFinite() && box.size_m.allFinite());
  EXPECT_TRUE((box.axes.transpose() * box.axes).isIdentity(1e-9)) << box.axes;
  EXPECT_NEAR(box.axes.determinant(), 1, 1e-9);
  EXPECT_GE(box.size_m.x(), box.size_m.y());
  EXPECT_GE(box.size_m.y(), box.size_m.z());
  EXPECT_GE(box.size_m.z(), 0);
}

TEST(ObjectShapes, AnAxisAlignedBoxIsMeasuredExactly) {
  Mesh mesh;
  add_box(mesh, {2, 0.5, 1}, turned({0, 0, 1}, 0, {10, -3, 4}));
  const auto shapes = object_shapes(mesh);
  ASSERT_EQ(shapes.size(), 1U);
  const ObjectShape& shape = shapes.front();
  EXPECT_EQ(shape.id, kFirst);
  EXPECT_EQ(shape.class_id, kChair);
  EXPECT_EQ(shape.vertices, mesh.vertices.size());
  EXPECT_TRUE(shape.min_m.isApprox(Vec3d(9, -3.25, 3.5), 1e-6)) << shape.min_m.transpose();
  EXPECT_TRUE(shape.max_m.isApprox(Vec3d(11, -2.75, 4.5), 1e-6)) << shape.max_m.transpose();
  EXPECT_TRUE(shape.centroid_m.isApprox(Vec3d(10, -3, 4), 1e-6)) << shape.centroid_m.transpose();
  EXPECT_NEAR(shape.area_m2, 2 * (2 * 0.5 + 0.5 * 1 + 2 * 1), 1e-5);
  EXPECT_TRUE(shape.oriented_box.size_m.isApprox(Vec3d(2, 1, 0.5), 1e-5)) << shape.oriented_box.size_m.transpose();
  EXPECT_TRUE(shape.oriented_box.center_m.isApprox(Vec3d(10, -3, 4), 1e-6));
}

TEST(ObjectShapes, TheOrientedBoxFollowsARotatedBox) {
  const std::vector<Vec3d> sizes = {{2, 0.5, 1}, {1, 1, 1}, {1.2, 1.2, 0.05}, {3, 0.2, 0.2}};
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const Vec3d& size : sizes) {
    for (int i = 0; i < 20; ++i) {
      const Pose pose = turned({normal(random), normal(random), normal(random)}, 3 * normal(random), {1, 2, 3});
      Mesh mesh;
      add_box(mesh, size, pose);
      const ObjectShape shape = object_shapes(mesh).front();
      Vec3d descending = size;
      std::sort(descending.data(), descending.data() + 3, std::greater<>());
      EXPECT_LT((shape.oriented_box.size_m - descending).cwiseAbs().maxCoeff(), 1e-3)
          << size.transpose() << " found as " << shape.oriented_box.size_m.transpose();
      EXPECT_LT((shape.oriented_box.center_m - pose.translation()).norm(), 1e-3);
      EXPECT_LT((shape.centroid_m - pose.translation()).norm(), 1e-5);
      expect_proper(shape.oriented_box);
      expect_holds_all(shape.oriented_box, mesh);
    }
  }
}

TEST(ObjectShapes, TheOrientedBoxIsNoLargerThanTheAxisAlignedOne) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20; ++i) {
    Mesh mesh;
    for (int k = 0; k < 2000; ++k) add_vertex(mesh, {normal(random), 0.3 * normal(random), 0.6 * normal(random)});
    const ObjectShape shape = object_shapes(mesh).front();
    expect_proper(shape.oriented_box);
    expect_holds_all(shape.oriented_box, mesh);
    const auto surface = [](const Vec3d& s) { return s.x() * s.y() + s.y() * s.z() + s.z() * s.x(); };
    EXPECT_LE(surface(shape.oriented_box.size_m), 1.02 * surface(shape.max_m - shape.min_m));
  }
}

TEST(ObjectShapes, TheCentroidIsWeightedByArea) {
  Mesh mesh;
  add_face(mesh, {0, 0, 0}, {4, 0, 0}, {0, 1, 0}, kFirst);   // 4 m2 around (2, 0.5, 0)
  add_face(mesh, {10, 0, 0}, {1, 0, 0}, {0, 1, 0}, kFirst);  // 1 m2 around (10.5, 0.5, 0), as many vertices
  const ObjectShape shape = object_shapes(mesh).front();
  EXPECT_NEAR(shape.area_m2, 5, 1e-6);
  EXPECT_TRUE(shape.centroid_m.isApprox(Vec3d((4 * 2 + 10.5) / 5, 0.5, 0), 1e-6)) << shape.centroid_m.transpose();
}

TEST(ObjectShapes, EveryIdButUnknownGetsAShapeInAscendingOrder) {
  Mesh mesh;
  add_box(mesh, {1, 1, 1}, turned({0, 0, 1}, 0.3, {5, 0, 0}), kSecond);
  add_box(mesh, {1, 1, 1}, Pose::Identity(), kFirst);
  add_box(mesh, {9, 9, 9}, Pose::Identity(), PanopticId::kUnknown);
  const auto shapes = object_shapes(mesh);
  ASSERT_EQ(shapes.size(), 2U);
  EXPECT_EQ(shapes[0].id, kFirst);
  EXPECT_EQ(shapes[1].id, kSecond);
  EXPECT_NEAR(shapes[1].centroid_m.x(), 5, 1e-5);
}

TEST(ObjectShapes, ABorderTriangleBelongsToTheMajorityOfItsCorners) {
  Mesh mesh;
  add_vertex(mesh, {0, 0, 0}, kFirst);
  add_vertex(mesh, {2, 0, 0}, kSecond);
  add_vertex(mesh, {0, 2, 0}, kSecond);
  mesh.triangles.push_back({0, 1, 2});
  const auto shapes = object_shapes(mesh);
  EXPECT_EQ(shapes[0].area_m2, 0);
  EXPECT_NEAR(shapes[1].area_m2, 2, 1e-6);
  EXPECT_EQ(speaker(1, 1, 2), 0);
  EXPECT_EQ(speaker(1, 2, 1), 0);
  EXPECT_EQ(speaker(2, 1, 1), 1);
  EXPECT_EQ(speaker(1, 2, 3), 0);
}

TEST(ObjectShapes, DegenerateObjectsHaveNoExtentAndNoNan) {
  const std::vector<std::vector<Vec3d>> clouds = {{{1, 2, 3}},
                                                  {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}},
                                                  {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}},
                                                  {{0, 0, 0}, {1, 0, 1}, {0, 1, 1}, {1, 1, 2}}};
  const std::vector<Vec3d> sizes = {{0, 0, 0}, {0, 0, 0}, {std::sqrt(27.0), 0, 0}, {std::sqrt(4.5), std::sqrt(1.5), 0}};
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    Mesh mesh;
    for (const Vec3d& point : clouds[i]) add_vertex(mesh, point);
    if (mesh.vertices.size() >= 3) mesh.triangles.push_back({0, 1, 2});
    if (mesh.vertices.size() >= 4) mesh.triangles.push_back({1, 3, 2});
    const ObjectShape shape = object_shapes(mesh).front();
    EXPECT_TRUE(shape.centroid_m.allFinite() && std::isfinite(shape.area_m2)) << i;
    expect_proper(shape.oriented_box);
    expect_holds_all(shape.oriented_box, mesh);
    EXPECT_LT((shape.oriented_box.size_m - sizes[i]).cwiseAbs().maxCoeff(), 1e-6)
        << i << ": " << shape.oriented_box.size_m.transpose();
  }
  EXPECT_TRUE(object_shapes({}).empty());
}

TEST(ObjectShapes, OneThreadAndTwoGiveTheSame) {
  Mesh mesh;
  for (int i = 0; i < 12; ++i) {
    add_box(mesh, {1.0 + i, 0.5, 0.2}, turned({1, 2, 3}, 0.4 * i, {3.0 * i, 0, 0}), static_cast<PanopticId>(5 + i));
  }
  set_thread_count(1);
  const auto one = object_shapes(mesh);
  set_thread_count(2);
  const auto two = object_shapes(mesh);
  set_thread_count(0);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].oriented_box.axes, two[i].oriented_box.axes);
    EXPECT_EQ(one[i].centroid_m, two[i].centroid_m);
  }
}

TEST(ObjectShapes, ClassAreasAddUpToTheSurface) {
  Mesh mesh;
  add_face(mesh, {0, 0, 0}, {4, 0, 0}, {0, 3, 0}, kFirst);
  add_face(mesh, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, kSecond);
  for (MeshVertex& vertex : mesh.vertices) vertex.class_id = static_cast<ClassId>(vertex.panoptic_id == kFirst ? 2 : 0);
  const auto areas = class_areas_m2(mesh);
  ASSERT_EQ(areas.size(), 2U);
  EXPECT_NEAR(areas.at(static_cast<ClassId>(2)), 12, 1e-5);
  EXPECT_NEAR(areas.at(ClassId::kUnknown), 1, 1e-6);
}

}  // namespace
}  // namespace panoptic
