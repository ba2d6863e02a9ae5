// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Points in the images of cameras.
#pragma once

#include "panoptic/geometry.h"

namespace panoptic {

// The column and row at which a camera sees a point of its own frame. REQUIRES a point in front of it.
template <typename Scalar>
Eigen::Matrix<Scalar, 2, 1> project(const Camera& camera, const Eigen::Matrix<Scalar, 3, 1>& p) {
  return {static_cast<Scalar>(camera.fx) * p.x() / p.z() + static_cast<Scalar>(camera.cx),
          static_cast<Scalar>(camera.fy) * p.y() / p.z() + static_cast<Scalar>(camera.cy)};
}

}  // namespace panoptic
