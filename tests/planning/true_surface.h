// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How far a place is from the true surface of a class in a simulated home.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "tests/planning/true_points.h"

namespace panoptic::test {

class TrueSurface {
 public:
  static constexpr double kFarthest_m = 0.2;

  TrueSurface(const Scene& scene, ClassId of_class) {
    constexpr double kPoint_m = 0.005;
    constexpr double kAll_m = std::numeric_limits<double>::infinity();
    for (const SceneObject& object : scene.objects) {
      if (object.class_id != of_class) continue;
      for_points_of(scene, object, -kAll_m, kAll_m, kPoint_m,
                    [&](const Vec3d& p) { points_[cell_of(p)].push_back(p.cast<float>()); });
    }
  }

  // At most kFarthest_m; up to 3 mm too much, since points stand for the surface.
  double distance_m(const Vec3d& at) const {
    double least = kFarthest_m;
    const Cell middle = cell_of(at);
    for (int n = 0; n < 27; ++n) {
      const auto found = points_.find({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1});
      if (found == points_.end()) continue;
      for (const Vec3f& point : found->second) least = std::min(least, (point.cast<double>() - at).norm());
    }
    return least;
  }

 private:
  using Cell = std::array<int, 3>;
  static Cell cell_of(const Vec3d& p) {
    const auto cell = [](double x) { return static_cast<int>(std::floor(x / kFarthest_m)); };
    return {cell(p.x()), cell(p.y()), cell(p.z())};
  }

  std::map<Cell, std::vector<Vec3f>> points_;
};

}  // namespace panoptic::test
