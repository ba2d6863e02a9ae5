// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The seam to nanoflann: finds the nearest of many points.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic {

// Immutable once made, so any thread may ask it.
class NearestPoints {
 public:
  struct Found {
    std::uint32_t index = 0;
    double distance_m = 0;
  };

  // REQUIRES finite points, less than 2^32 of them.
  explicit NearestPoints(std::vector<Vec3f> points);
  ~NearestPoints();
  NearestPoints(const NearestPoints&) = delete;
  NearestPoints& operator=(const NearestPoints&) = delete;

  // The nearest point, at the same distance the one with the lowest index; nothing if there are no points.
  std::optional<Found> nearest(const Vec3f& point) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace panoptic
