// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A corner of a room with a ball in it, painted so that every place looks different, and a bare wall.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "panoptic/mapper.h"
#include "tests/fusion/scenes.h"

namespace panoptic::test {

inline Camera room_camera() { return {320, 240, 260, 260, 159.5, 119.5}; }

inline Surface room() {
  return nearest_of({plane(Vec3d::UnitY(), 1.2), plane(Vec3d::UnitZ(), 2), plane(Vec3d::UnitX(), 1.8),
                     plane(Vec3d::UnitX(), -1.8), sphere({0.3, 0.9, 1.2}, 0.3)});
}

inline Surface bare_wall() { return plane(Vec3d::UnitZ(), 2); }

// Smooth noise in space, cells of `cell_m`: values at the corners of a grid, mixed.
inline double noise_at(const Vec3d& p, double cell_m) {
  const auto corner = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL ^
                      static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL ^
                      static_cast<std::uint64_t>(z) * 0x165667B19E3779F9ULL;
    h ^= h >> 29;
    h *= 0xBF58476D1CE4E5B9ULL;
    return static_cast<double>((h ^ h >> 32) & 0xFFFF) / 65535;
  };
  const Vec3d q = p / cell_m;
  const Vec3d whole = q.array().floor();
  const Vec3d t = q - whole;
  double value = 0;
  for (int i = 0; i < 8; ++i) {
    const double weight = (i & 1 ? t.x() : 1 - t.x()) * (i & 2 ? t.y() : 1 - t.y()) * (i & 4 ? t.z() : 1 - t.z());
    value += weight * corner(std::llround(whole.x()) + (i & 1), std::llround(whole.y()) + (i >> 1 & 1),
                             std::llround(whole.z()) + (i >> 2));
  }
  return value;
}

inline Frame paint(Frame frame) {
  Image<Rgb> color(frame.color.width(), frame.color.height());
  for (int v = 0; v < color.height(); ++v) {
    for (int u = 0; u < color.width(); ++u) {
      const float z = frame.depth(u, v);
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, double{z});
      const auto grey = static_cast<std::uint8_t>(z > 0 ? 40 + 90 * noise_at(p, 0.12) + 90 * noise_at(p, 0.04) : 0);
      color(u, v) = {grey, grey, grey};
    }
  }
  frame.color = std::move(color);
  return frame;
}

// The way of a camera that looks round in the room and comes back.
inline Pose room_pose(int n, int frames) {
  const double a = 2 * std::numbers::pi * n / frames;
  return look_at({0.5 * std::sin(a), 0.1 * std::sin(2 * a), -0.6 + 0.2 * std::cos(a)}, {0.9 * std::sin(a), 0.5, 2});
}

inline Frame room_frame(int n, int frames) {
  Frame frame = paint(render(room(), room_camera(), room_pose(n, frames), n));
  frame.time_s = n / 30.0;
  return frame;
}

inline Mapper room_mapper() {
  Options options;
  options.map.voxel_size_m = 0.03F;
  options.regularizer.enabled = false;
  return {options, test_labels()};
}

}  // namespace panoptic::test
