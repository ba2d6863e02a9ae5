// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses from how they stand to one another: the one seam to Ceres.
#pragma once

#include <cstddef>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic {

// Pose b in the frame of pose a, as measured.
struct PoseEdge {
  std::size_t a = 0;
  std::size_t b = 0;
  Pose a_from_b = Pose::Identity();
  double distance_noise_m = 0.01;
  double angle_noise_rad = 0.005;
  bool may_be_wrong = false;  // then it counts less the worse it fits
};

// The poses that fit the edges best; the first `fixed` ones stay. One thread, so the same each time on one machine. REQUIRES
// edges between poses of the list.
std::vector<Pose> optimized(std::vector<Pose> poses, const std::vector<PoseEdge>& edges, std::size_t fixed = 1);

}  // namespace panoptic
