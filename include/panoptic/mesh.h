// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Place and size of the things of a mesh. Metres, world axes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"

namespace panoptic {

struct MeshVertex {
  Vec3f position = Vec3f::Zero();  // metres
  Vec3f normal = Vec3f::Zero();    // unit length, out of the surface towards free space
  Rgb color;
  ClassId class_id = ClassId::kUnknown;
  PanopticId panoptic_id = PanopticId::kUnknown;
};

// Vertices are shared by the triangles around them. Triangles run counter-clockwise seen from free space.
struct Mesh {
  std::vector<MeshVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

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

// One shape per panoptic id but kUnknown, stuff included, ascending. A triangle belongs to the id of most of its corners, else of
// the first. Vertices must be finite. Any surface will do: single points, lines and planes give boxes without extent there, never
// NaN.
std::vector<ObjectShape> object_shapes(const Mesh& mesh);

// Surface in square metres of every class that has any, kUnknown included. A triangle belongs to the class of most of its
// corners, else of the first.
std::map<ClassId, double> class_areas_m2(const Mesh& mesh);

}  // namespace panoptic
