// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A registered frame together with where it was taken, as the update steps of integration want it.
#pragma once

#include "panoptic/fusion/integrate_kernels.h"
#include "panoptic/geometry.h"

namespace panoptic {

struct FrameView {
  KernelFrame pixels;
  Camera camera;
  Eigen::Matrix3f world_from_camera;  // rotation
  Vec3d camera_in_world_m;
  float farthest_m = 0;  // the largest depth

  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(pixels.width) + static_cast<std::size_t>(u);
  }

  // The direction of pixel (u, v) in the world, scaled so that its depth (camera z) is 1.
  Vec3f ray(int u, int v) const {
    const Vec3f in_camera(static_cast<float>((u - camera.cx) / camera.fx), static_cast<float>((v - camera.cy) / camera.fy), 1.0F);
    return world_from_camera * in_camera;
  }
};

}  // namespace panoptic
