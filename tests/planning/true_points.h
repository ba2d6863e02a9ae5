// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The true surface of a simulated home as points.
#pragma once

#include <algorithm>
#include <array>

#include "panoptic/sim/scene.h"

namespace panoptic::test {

// Calls visit(point) for points of the triangle, at most `apart_m` from one another, that lie between the two heights.
template <typename Visit>
void for_points_of(const std::array<Vec3d, 3>& corner, double low_m, double high_m, double apart_m, const Visit& visit) {
  const double longest =
      std::max({(corner[1] - corner[0]).norm(), (corner[2] - corner[0]).norm(), (corner[2] - corner[1]).norm()});
  const auto [lowest, highest] = std::minmax({corner[0].z(), corner[1].z(), corner[2].z()});
  if (highest <= low_m || lowest >= high_m) return;
  const int steps = 1 + static_cast<int>(longest / apart_m);
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps - i; ++j) {
      const Vec3d p = corner[0] + (corner[1] - corner[0]) * i / steps + (corner[2] - corner[0]) * j / steps;
      if (p.z() > low_m && p.z() < high_m) visit(p);
    }
  }
}

// The same for all triangles of an object, in the world.
template <typename Visit>
void for_points_of(const Scene& scene, const SceneObject& object, double low_m, double high_m, double apart_m,
                   const Visit& visit) {
  const SceneModel& model = scene.models[object.model];
  for (const auto& triangle : model.triangles) {
    std::array<Vec3d, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = object.world_from_object * model.positions[triangle[k]].cwiseProduct(object.scale).cast<double>();
    }
    for_points_of(corner, low_m, high_m, apart_m, visit);
  }
}

}  // namespace panoptic::test
