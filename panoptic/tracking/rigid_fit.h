// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The rigid motion between two sets of points of which only some belong together: random samples of three (Fischler and Bolles
// 1981), each solved in closed form (Umeyama 1991).
#pragma once

#include <vector>

#include "panoptic/tracking/features.h"

namespace panoptic {

struct RigidFit {
  Pose a_from_b = Pose::Identity();
  std::size_t inliers = 0;
};

// The motion that most of the matches agree with. The samples are drawn the same way each time.
RigidFit fit_rigid(const std::vector<Feature>& a, const std::vector<Feature>& b, const std::vector<FeatureMatch>& matches);

}  // namespace panoptic
