// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A labelled room as a map would show it: walls and floor seen from inside, a table and two chairs, no ceiling. World axes are
// those of a level first camera: x right, y down, z forward, so that "up" is -y.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/mesh.h"

namespace panoptic::test {

inline LabelSet room_labels() {
  return {"room",
          {{static_cast<ClassId>(1), "wall", false, {174, 199, 232}},
           {static_cast<ClassId>(2), "floor", false, {152, 223, 138}},
           {static_cast<ClassId>(3), "chair", true, {188, 189, 34}},
           {static_cast<ClassId>(4), "dining table", true, {255, 152, 150}}}};
}

struct Paint {
  Rgb color;
  ClassId class_id = ClassId::kUnknown;
  PanopticId panoptic_id = PanopticId::kUnknown;
};

inline Paint paint(Rgb color, int class_id, int panoptic_id) {
  return {color, static_cast<ClassId>(class_id), static_cast<PanopticId>(panoptic_id)};
}

// The parallelogram corner + [0, 1] a + [0, 1] b in squares of at most `step_m`; its front is the side that a x b points to.
inline void add_sheet(Mesh& mesh, const Vec3f& corner, const Vec3f& a, const Vec3f& b, const Paint& paint, float step_m) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const int columns = std::max(1, static_cast<int>(std::ceil(a.norm() / step_m)));
  const int rows = std::max(1, static_cast<int>(std::ceil(b.norm() / step_m)));
  const Vec3f normal = a.cross(b).normalized();
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const Vec3f at = corner + a * (static_cast<float>(i) / static_cast<float>(columns)) +
                       b * (static_cast<float>(j) / static_cast<float>(rows));
      mesh.vertices.push_back({at, normal, paint.color, paint.class_id, paint.panoptic_id});
    }
  }
  const auto width = static_cast<std::uint32_t>(columns + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rows); ++j) {
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(columns); ++i) {
      const std::uint32_t v = first + j * width + i;
      mesh.triangles.push_back({v, v + 1, v + width + 1});
      mesh.triangles.push_back({v, v + width + 1, v + width});
    }
  }
}

// A closed box seen from outside.
inline void add_box(Mesh& mesh, const Vec3f& low, const Vec3f& high, const Paint& paint, float step_m) {
  const Vec3f size = high - low;
  const Vec3f x(size.x(), 0, 0);
  const Vec3f y(0, size.y(), 0);
  const Vec3f z(0, 0, size.z());
  add_sheet(mesh, low, y, x, paint, step_m);
  add_sheet(mesh, low, z, y, paint, step_m);
  add_sheet(mesh, low, x, z, paint, step_m);
  add_sheet(mesh, high, -x, -y, paint, step_m);
  add_sheet(mesh, high, -y, -z, paint, step_m);
  add_sheet(mesh, high, -z, -x, paint, step_m);
}

// 6 m x 4 m, walls 2.5 m high.
inline Mesh room(float step_m) {
  Mesh mesh;
  const Paint wall = paint({200, 190, 170}, 1, 1);
  const Vec3f x(6, 0, 0);
  const Vec3f up(0, -2.5F, 0);
  const Vec3f z(0, 0, 4);
  add_sheet(mesh, {0, 0, 0}, x, z, paint({120, 90, 60}, 2, 2), step_m);
  add_sheet(mesh, {6, 0, 0}, -x, up, wall, step_m);
  add_sheet(mesh, {0, 0, 4}, x, up, wall, step_m);
  add_sheet(mesh, {0, 0, 0}, z, up, wall, step_m);
  add_sheet(mesh, {6, 0, 4}, -z, up, wall, step_m);
  const Paint table = paint({150, 110, 70}, 4, 5);
  add_box(mesh, {2, -0.75F, 1.5F}, {4, -0.7F, 2.5F}, table, step_m);
  for (const auto& [leg_x, leg_z] : {std::pair{2.05F, 1.55F}, {3.9F, 1.55F}, {2.05F, 2.4F}, {3.9F, 2.4F}}) {
    add_box(mesh, {leg_x, -0.7F, leg_z}, {leg_x + 0.05F, 0, leg_z + 0.05F}, table, step_m);
  }
  for (const int chair : {0, 1}) {
    const Paint seat = paint(chair == 0 ? Rgb{60, 60, 160} : Rgb{160, 60, 60}, 3, 6 + chair);
    const float left = 2.2F + static_cast<float>(chair);
    add_box(mesh, {left, -0.45F, 2.7F}, {left + 0.45F, -0.4F, 3.15F}, seat, step_m);
    add_box(mesh, {left, -0.9F, 3.15F}, {left + 0.45F, 0, 3.2F}, seat, step_m);
  }
  add_box(mesh, {5.2F, -1.2F, 0.1F}, {5.9F, 0, 0.8F}, paint({90, 90, 90}, 0, 0), step_m);  // nobody knows what this is
  return mesh;
}

}  // namespace panoptic::test
