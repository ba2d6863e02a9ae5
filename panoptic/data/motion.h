// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Small motions of a camera as six numbers: translation in metres, then rotation vector in radians, in the camera's own frame.
#pragma once

#include "panoptic/geometry.h"

namespace panoptic {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The pose of a rotation vector and a translation. It is not the exponential of SE(3): translation and rotation stay apart.
Pose moved_by(const Vector6d& motion);
Vector6d motion_of(const Pose& pose);

// A share of a motion: 0 is none, 1 the whole.
Pose scaled(const Pose& motion, double share);

// "this far apart": metres and radians between two poses.
struct PoseDifference {
  double distance_m = 0;
  double angle_rad = 0;
};
PoseDifference difference(const Pose& a, const Pose& b);

}  // namespace panoptic
