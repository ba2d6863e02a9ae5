// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How far one is, from above, from the true surface of a simulated home: its triangles as points 5 mm apart.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "panoptic/base/polygon.h"
#include "tests/planning/true_points.h"

namespace panoptic::test {

class TrueObstacles {
 public:
  static constexpr double kPoint_m = 0.005;
  static constexpr double kFarthest_m = 0.5;

  // Everything between the two heights, or what is of this class.
  TrueObstacles(const Scene& scene, double low_m, double high_m, std::optional<ClassId> of_class = {}) {
    for (const SceneObject& object : scene.objects) {
      if (of_class && object.class_id != *of_class) continue;
      for_points_of(scene, object, low_m, high_m, kPoint_m, [&](const Vec3d& p) { add(p); });
    }
  }

  // At most kFarthest_m.
  double clearance_m(const Vec2d& at) const {
    double least = kFarthest_m;
    for (int n = 0; n < 9; ++n) {
      const auto found = squares_.find(key(at + kFarthest_m * Vec2d(n % 3 - 1, n / 3 - 1), kFarthest_m));
      if (found == squares_.end()) continue;
      for (const Vec2d& point : found->second) least = std::min(least, (point - at).norm());
    }
    return least;
  }

 private:
  static std::int64_t key(const Vec2d& at, double size_m) {
    constexpr std::int64_t kSide = 1 << 20;
    return kSide * std::lround(at.x() / size_m) + std::lround(at.y() / size_m);
  }

  void add(const Vec3d& p) {
    const Vec2d point(std::round(p.x() / kPoint_m) * kPoint_m, std::round(p.y() / kPoint_m) * kPoint_m);
    if (points_.insert(key(point, kPoint_m)).second) squares_[key(point, kFarthest_m)].push_back(point);
  }

  std::unordered_set<std::int64_t> points_;
  std::unordered_map<std::int64_t, std::vector<Vec2d>> squares_;
};

}  // namespace panoptic::test
