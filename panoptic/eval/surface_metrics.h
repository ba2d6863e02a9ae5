// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures how well one surface covers another, on points spread evenly over both.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/base/json_value.h"
#include "panoptic/evaluation.h"
#include "panoptic/geometry.h"

namespace panoptic {

// Triangles by reference, whatever they belong to.
struct Surface {
  std::vector<Vec3f> positions;
  std::span<const std::array<std::uint32_t, 3>> triangles;
};

// `count` points, uniform by area and the same every time; none if the surface has no area.
std::vector<Vec3f> sample_surface(const Surface& surface, std::size_t count);

class SurfaceMetrics {
 public:
  // Compares by samples of both surfaces (about one per 3 cm2, at most kMaxSamples). A scene where one of them has no area adds
  // to the counts of the other, all missed, and to no mean distance.
  void add(const Surface& map, const Surface& truth);

  SurfaceScores scores() const;

  // The counts for another process, and their addition. Throws Error unless they are sound (saved_counts.cpp).
  Json saved() const;
  void add_saved(const JsonValue& saved);

  static constexpr std::size_t kMaxSamples = 200000;

 private:
  struct Side {
    std::size_t points = 0;
    std::size_t measured = 0;  // points with a distance
    double distance_sum_m = 0;
    std::array<std::size_t, 2> near{};
  };
  static void count(const std::vector<Vec3f>& points, const std::vector<Vec3f>& others, Side& side);

  Side map_;
  Side truth_;
};

}  // namespace panoptic
