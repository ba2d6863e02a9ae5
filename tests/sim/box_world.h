// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A room of boxes, rendered by intersecting rays: what the prediction noise is tried on, without furniture or Embree.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "panoptic/sim/simulation.h"

namespace panoptic::test {

struct BoxThing {
  Eigen::AlignedBox3d box;
  ClassId class_id;
  std::uint16_t instance;
};

constexpr ClassId kWall{1};
constexpr ClassId kFloor{2};
constexpr ClassId kChair{5};

// 6 x 5 x 2.6 m: four chairs side by side, a sofa, a table, a cabinet, a picture, a small sink far off, a bookshelf.
inline const std::vector<BoxThing>& box_things() {
  const auto thing = [](Vec3d low, Vec3d high, int class_id, int instance) {
    return BoxThing{{low, high}, static_cast<ClassId>(class_id), static_cast<std::uint16_t>(instance)};
  };
  static const std::vector<BoxThing> kThings = {
      thing({3, 0.5, 0}, {3.5, 1, 0.9}, 5, 1),         thing({3, 1.05, 0}, {3.5, 1.55, 0.9}, 5, 2),
      thing({3, 1.6, 0}, {3.5, 2.1, 0.9}, 5, 3),       thing({3, 2.15, 0}, {3.5, 2.65, 0.9}, 5, 4),
      thing({1.5, 4, 0}, {3.5, 4.9, 0.8}, 6, 5),       thing({2.5, 2.9, 0}, {3.7, 3.7, 0.7}, 7, 6),
      thing({5.4, 0.2, 0}, {5.95, 1.4, 1.8}, 3, 7),    thing({5.95, 2, 1.2}, {5.99, 3, 1.9}, 11, 8),
      thing({5.7, 1.6, 0.8}, {5.9, 1.8, 0.95}, 34, 9), thing({5.4, 3.5, 0}, {5.95, 4.8, 2}, 10, 10),
  };
  return kThings;
}

struct BoxHit {
  double depth = std::numeric_limits<double>::infinity();
  ClassId class_id = ClassId::kUnknown;
  std::uint16_t instance = 0;
};

// Depth at which the ray enters a box, or leaves it where it starts within; infinite if it misses.
inline double ray_box(const Eigen::AlignedBox3d& box, const Vec3d& eye, const Vec3d& ray) {
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (box.min()[axis] - eye[axis]) / ray[axis];
    const double b = (box.max()[axis] - eye[axis]) / ray[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave || leave <= 0) return std::numeric_limits<double>::infinity();
  return enter > 0 ? enter : leave;
}

inline BoxHit look_along(const Vec3d& eye, const Vec3d& ray) {
  BoxHit hit;
  hit.depth = ray_box({Vec3d(0, 0, 0), Vec3d(6, 5, 2.6)}, eye, ray);
  const double z = eye.z() + hit.depth * ray.z();
  hit.class_id = z < 1e-6 ? kFloor : (z > 2.6 - 1e-6 ? ClassId::kUnknown : kWall);  // the ceiling is void
  for (const BoxThing& thing : box_things()) {
    const double depth = ray_box(thing.box, eye, ray);
    if (depth < hit.depth) hit = {depth, thing.class_id, thing.instance};
  }
  return hit;
}

// Seen from `eye` towards +x, turned left by `yaw` and a little downwards.
inline SimulatedFrame box_frame(std::int64_t index, const Vec3d& eye, double yaw = 0) {
  constexpr Camera kCamera{320, 240, 280, 280, 159.5, 119.5};
  constexpr double kPitch = -0.25;
  const Vec3d z(std::cos(yaw) * std::cos(kPitch), std::sin(yaw) * std::cos(kPitch), std::sin(kPitch));
  const Vec3d x = z.cross(Vec3d::UnitZ()).normalized();
  SimulatedFrame f;
  f.frame.index = index;
  f.frame.depth_camera = f.frame.color_camera = kCamera;
  f.true_world_from_camera.linear() << x, z.cross(x), z;
  f.true_world_from_camera.translation() = eye;
  f.frame.world_from_camera = f.true_world_from_camera;
  f.rendering.depth = Image<float>(kCamera.width, kCamera.height);
  f.rendering.color = Image<Rgb>(kCamera.width, kCamera.height);
  f.rendering.class_id = Image<ClassId>(kCamera.width, kCamera.height);
  f.rendering.instance = Image<std::uint16_t>(kCamera.width, kCamera.height);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const BoxHit hit = look_along(eye, f.true_world_from_camera.linear() * back_project(kCamera, u, v, 1));
      f.rendering.depth(u, v) = static_cast<float>(hit.depth);
      f.rendering.class_id(u, v) = hit.class_id;
      f.rendering.instance(u, v) = hit.instance;
    }
  }
  f.frame.depth = f.rendering.depth;
  f.frame.color = f.rendering.color;
  return f;
}

}  // namespace panoptic::test
