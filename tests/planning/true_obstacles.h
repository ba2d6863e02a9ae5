// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How far one is, from above, from the true surface of a simulated home: its triangles as points 5 mm apart.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "panoptic/base/polygon.h"
#include "panoptic/sim/scene.h"

namespace panoptic::test {

class TrueObstacles {
 public:
  static constexpr double kPoint_m = 0.005;
  static constexpr double kFarthest_m = 0.5;

  // Everything between the two heights, or what is of this class.
  TrueObstacles(const Scene& scene, double low_m, double high_m, std::optional<ClassId> of_class = {})
      : low_m_(low_m), high_m_(high_m) {
    for (const SceneObject& object : scene.objects) {
      if (of_class && object.class_id != *of_class) continue;
      const SceneModel& model = scene.models[object.model];
      for (const auto& triangle : model.triangles) {
        std::array<Vec3d, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) {
          corner[k] = object.world_from_object * model.positions[triangle[k]].cwiseProduct(object.scale).cast<double>();
        }
        add(corner);
      }
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

  void add(const std::array<Vec3d, 3>& corner) {
    const double longest =
        std::max({(corner[1] - corner[0]).norm(), (corner[2] - corner[0]).norm(), (corner[2] - corner[1]).norm()});
    const auto [lowest, highest] = std::minmax({corner[0].z(), corner[1].z(), corner[2].z()});
    if (highest <= low_m_ || lowest >= high_m_) return;
    const int steps = 1 + static_cast<int>(longest / kPoint_m);
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; j <= steps - i; ++j) {
        const Vec3d p = corner[0] + (corner[1] - corner[0]) * i / steps + (corner[2] - corner[0]) * j / steps;
        if (p.z() <= low_m_ || p.z() >= high_m_) continue;
        const Vec2d point(std::round(p.x() / kPoint_m) * kPoint_m, std::round(p.y() / kPoint_m) * kPoint_m);
        if (points_.insert(key(point, kPoint_m)).second) squares_[key(point, kFarthest_m)].push_back(point);
      }
    }
  }

  double low_m_;
  double high_m_;
  std::unordered_set<std::int64_t> points_;
  std::unordered_map<std::int64_t, std::vector<Vec2d>> squares_;
};

}  // namespace panoptic::test
