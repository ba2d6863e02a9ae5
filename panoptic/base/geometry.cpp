// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/geometry.h"

#include <Eigen/SVD>

namespace panoptic {

Camera resized(const Camera& camera, int width, int height) {
  if (width == camera.width && height == camera.height) return camera;  // not even a rounding error
  const double sx = static_cast<double>(width) / camera.width;
  const double sy = static_cast<double>(height) / camera.height;
  return {width, height, camera.fx * sx, camera.fy * sy, (camera.cx + 0.5) * sx - 0.5, (camera.cy + 0.5) * sy - 0.5};
}

Pose rigid(const Eigen::Matrix4d& matrix) {
  Pose pose = Pose::Identity();
  pose.translation() = matrix.topRightCorner<3, 1>();
  if (!matrix.allFinite()) {
    pose.linear() = matrix.topLeftCorner<3, 3>();
    return pose;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix.topLeftCorner<3, 3>(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (rotation.determinant() < 0) {
    Eigen::Matrix3d u = svd.matrixU();
    u.col(2) *= -1;
    rotation = u * svd.matrixV().transpose();
  }
  pose.linear() = rotation;
  return pose;
}

bool is_finite(const Pose& pose) { return pose.matrix().allFinite(); }

bool is_rigid(const Pose& pose, double tolerance) {
  const Eigen::Matrix3d r = pose.linear();
  const double skew = (r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  return is_finite(pose) && skew <= tolerance && std::abs(r.determinant() - 1) <= tolerance;
}

}  // namespace panoptic
