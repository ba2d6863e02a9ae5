// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the things of a mesh are and how large. Metres, world axes.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "panoptic/base/geometry.h"
#include "panoptic/data/mesh.h"

namespace panoptic {

struct OrientedBox {
  Vec3d center_m = Vec3d::Zero();
  // The columns are the box's edge directions in the world: unit, orthogonal, right-handed, longest edge first.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Vec3d size_m = Vec3d::Zero();  // full edge lengths along those axes, descending
};

struct ObjectShape {
  PanopticId id = PanopticId::kUnknown;
  ClassId class_id = ClassId::kUnknown;  // of most of its vertices
  std::size_t vertices = 0;
  Vec3d min_m = Vec3d::Zero();  // the axis-aligned box of its vertices
  Vec3d max_m = Vec3d::Zero();
  OrientedBox oriented_box;          // holds every vertex; near the smallest such box
  Vec3d centroid_m = Vec3d::Zero();  // of the surface; the mean of the vertices if there is no surface
  double area_m2 = 0;
};

// The corner (0, 1, 2) that speaks for a triangle whose corners bear labels a, b, c: one of the majority, else the first.
template <typename Label>
constexpr int speaker(Label a, Label b, Label c) {
  return a != b && b == c ? 1 : 0;
}

// One shape per panoptic id but kUnknown, stuff included, ascending. A triangle belongs to its speaker's id.
// Vertices must be finite. Any surface will do: single points, lines and planes give boxes without extent there, never NaN.
std::vector<ObjectShape> object_shapes(const Mesh& mesh);

// Surface in square metres of every class that has any, kUnknown included. A triangle belongs to its speaker's class.
std::map<ClassId, double> class_areas_m2(const Mesh& mesh);

}  // namespace panoptic
