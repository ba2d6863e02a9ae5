// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A registered frame together with where it was taken, as the update steps of integration want it.
#pragma once

#include "panoptic/frame.h"
#include "panoptic/fusion/integrate_kernels.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/geometry.h"
#include "panoptic/map/voxel_grid.h"

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

  BlockInCamera in_camera(BlockIndex block, float voxel_size_m) const {
    const Eigen::Matrix3f camera_from_world = world_from_camera.transpose();
    const Eigen::Matrix3f step = camera_from_world * voxel_size_m;
    const Vec3d first_m = center_m(first_voxel(block), voxel_size_m);
    const Vec3f origin = camera_from_world * (first_m - camera_in_world_m).cast<float>();
    BlockInCamera place{};
    for (int a = 0; a < 3; ++a) {
      place.origin[a] = origin[a];
      place.step_x[a] = step(a, 0);
      place.step_y[a] = step(a, 1);
      place.step_z[a] = step(a, 2);
    }
    return place;
  }
};

// The view of a frame's depth alone: no votes, no limit.
inline FrameView depth_view(const Frame& frame, const RegisteredFrame& registered) {
  const Camera& c = frame.depth_camera;
  KernelFrame pixels{.depth = registered.depth.data(), .width = registered.width, .height = registered.height};
  pixels.fx = static_cast<float>(c.fx);
  pixels.fy = static_cast<float>(c.fy);
  pixels.cx = static_cast<float>(c.cx);
  pixels.cy = static_cast<float>(c.cy);
  return {pixels, c, frame.world_from_camera.linear().cast<float>(), frame.world_from_camera.translation(),
          registered.farthest_m};
}

}  // namespace panoptic
