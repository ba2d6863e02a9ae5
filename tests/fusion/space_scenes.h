// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map that takes up frames as a mapper does: voxels first, then free space and carving.
#pragma once

#include <string>
#include <vector>

#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/space_observer.h"
#include "tests/fusion/scenes.h"

namespace panoptic::test {

inline MapOptions voxels_of(float voxel_m) {
  MapOptions options;
  options.voxel_size_m = voxel_m;
  return options;
}

struct SeeingMap {
  PanopticMap map;
  Integrator integrator;
  Registration registration{DepthOptions{}};
  SpaceObserver observer;
  std::uint64_t frames = 0;

  explicit SeeingMap(float voxel_m, const CarvingOptions& carving = {}, const std::string& method = "projective")
      : map(voxels_of(voxel_m), test_labels()), integrator({method}, map.voxels), observer(voxels_of(voxel_m), carving) {}

  // Every pixel is wall. Returns what was carved.
  std::vector<CarvedVoxels> add(const Frame& frame) {
    const RegisteredFrame& registered = registration.apply(frame, {});
    const std::vector<LabelSlot> wall(registered.depth.size(), LabelSlot{1});
    integrator.integrate(frame, registered, wall, map.voxels);
    std::vector<CarvedVoxels> carved = observer.see(frame, registered, frames++, {}, map);
    clear(carved, map.voxels);
    return carved;
  }
};

// A camera with tiles as wide, in the angle, as those of common depth cameras.
inline Camera space_camera() { return small_camera(320, 240); }

// A room of 4 x 2.4 x 5 m around the origin; y points down. What else is in it comes on top.
inline Surface room(std::vector<Surface> things = {}) {
  for (const auto& [normal, offset] :
       {std::pair(Vec3d(1, 0, 0), 2.0), std::pair(Vec3d(1, 0, 0), -2.0), std::pair(Vec3d(0, 1, 0), 1.2),
        std::pair(Vec3d(0, 1, 0), -1.2), std::pair(Vec3d(0, 0, 1), 2.5), std::pair(Vec3d(0, 0, 1), -2.5)}) {
    things.push_back(plane(normal, offset));
  }
  return nearest_of(std::move(things));
}

// Poses on an arc of radius `radius_m` around the origin, that look at `target`.
inline Pose on_arc(int i, double radius_m, const Vec3d& target) {
  const double angle = 0.35 * i;
  return look_at({radius_m * std::cos(angle), -0.2 + 0.05 * (i % 5), radius_m * std::sin(angle) - 1}, target);
}

}  // namespace panoptic::test
