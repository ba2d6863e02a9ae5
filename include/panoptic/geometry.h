// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Points, poses and pinhole cameras. Metres; camera axes x right, y down, z forward; world axes as the recording has them.
// Transforms are named target_from_source, so that products cancel: world_from_camera * camera_from_object.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

namespace panoptic {

using Vec3f = Eigen::Vector3f;
using Vec3d = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;

// A pinhole camera without distortion. Pixel centres lie at integer coordinates:
// u = fx * X / Z + cx, v = fy * Y / Z + cy.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;

  bool operator==(const Camera&) const = default;
};

// The point in the camera frame that pixel (u, v) sees at depth z (planar, not along the ray).
inline Vec3d back_project(const Camera& camera, double u, double v, double z) {
  return {(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z};
}

// The same camera after its image was resized to width x height. Pixel centres are at integers, so the image spans
// [-0.5, width - 0.5] and the principal point moves by (c + 0.5) * ratio - 0.5.
Camera resized(const Camera& camera, int width, int height);

// The closest rigid pose to a 4x4 matrix whose rotation part is nearly orthonormal (recordings carry rounded matrices with
// determinants of 0.9995). The result is not rigid where the input holds NaN or infinity: check is_finite first.
Pose rigid(const Eigen::Matrix4d& matrix);

bool is_finite(const Pose& pose);

// True if the rotation part is orthonormal with determinant +1, each within the tolerance.
bool is_rigid(const Pose& pose, double tolerance = 1e-3);

}  // namespace panoptic
