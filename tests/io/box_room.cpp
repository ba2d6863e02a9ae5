// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/io/box_room.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace panoptic::test {
namespace {

const Camera kCamera{160, 120, 140, 140, 79.5, 59.5};
constexpr double kRate_hz = 30;

// Where a ray leaves an axis-aligned box that it starts in, or enters one that it starts outside; infinity if it does not.
double distance(const Vec3d& origin, const Vec3d& ray, const Vec3d& low, const Vec3d& high, bool from_inside) {
  double enter = 0;
  double leave = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double to_low = (low[a] - origin[a]) / ray[a];
    const double to_high = (high[a] - origin[a]) / ray[a];
    enter = std::max(enter, std::min(to_low, to_high));
    leave = std::min(leave, std::max(to_low, to_high));
  }
  if (from_inside) return leave;
  return enter > 0 && enter < leave ? enter : std::numeric_limits<double>::infinity();
}

// World axes: x and y along the walls, z up.
Pose looking(const Vec3d& from, double heading_rad, double down_rad) {
  const Vec3d forward(std::cos(heading_rad) * std::cos(down_rad), std::sin(heading_rad) * std::cos(down_rad),
                      -std::sin(down_rad));
  const Vec3d right = forward.cross(Vec3d::UnitZ()).normalized();
  Pose pose = Pose::Identity();
  pose.linear().col(0) = right;
  pose.linear().col(1) = forward.cross(right);
  pose.linear().col(2) = forward;
  pose.translation() = from;
  return pose;
}

}  // namespace

ReadResult BoxRoom::read(std::size_t position) const {
  Frame frame;
  frame.index = static_cast<std::int64_t>(position);
  frame.time_s = static_cast<double>(position) / kRate_hz;
  frame.depth_camera = frame.color_camera = camera;
  frame.world_from_camera = told[position];
  frame.color = Image<Rgb>(camera.width, camera.height);
  Image<float> depth(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Vec3d ray = way[position].linear() * back_project(kCamera, u, v, 1);
      const Vec3d origin = way[position].translation();
      const double room = distance(origin, ray, {0, 0, 0}, {5, 4, 2.5}, true);
      const double box = distance(origin, ray, {3.2, 2.4, 0}, {4.1, 3.1, 1.1}, false);
      depth(u, v) = static_cast<float>(depth_factor * std::min(room, box));
    }
  }
  spoil(depth);
  frame.depth = std::move(depth);
  return {std::move(frame), {}};
}

BoxRoom walk_through_a_room(int frames) {
  std::vector<Pose> way;
  for (int i = 0; i < frames; ++i) {
    const double t = static_cast<double>(i) / frames;
    way.push_back(looking({0.9 + 1.6 * t, 1 + 1.2 * t * t, 1.4}, 0.2 + 1.5 * t, 0.25 + 0.2 * std::sin(5 * t)));
  }
  return BoxRoom(std::move(way));
}

BoxRoom turn_in_a_room(int frames) {
  std::vector<Pose> way;
  for (int i = 0; i < frames; ++i) {
    const double t = static_cast<double>(i) / frames;
    way.push_back(looking({1.5, 1.5, 1.4}, 3 * t, 0.25 + 0.2 * std::sin(5 * t)));
  }
  return BoxRoom(std::move(way));
}

}  // namespace panoptic::test
