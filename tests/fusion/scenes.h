// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Small worlds with known surfaces, rendered to posed frames by intersecting rays.
#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/segmentation.h"

namespace panoptic::test {

inline Camera small_camera(int width = 160, int height = 120) {
  return {width, height, 0.9 * width, 0.9 * width, 0.5 * (width - 1), 0.5 * (height - 1)};
}

// A camera at `eye` that looks at `target`, with the image's down axis as near to `down` as that allows.
inline Pose look_at(const Vec3d& eye, const Vec3d& target, const Vec3d& down = Vec3d::UnitY()) {
  const Vec3d z = (target - eye).normalized();
  const Vec3d hint = std::abs(z.dot(down.normalized())) > 0.99 ? Vec3d::UnitZ() : down;
  const Vec3d x = hint.cross(z).normalized();
  Pose pose = Pose::Identity();
  pose.linear().col(0) = x;
  pose.linear().col(1) = z.cross(x);
  pose.linear().col(2) = z;
  pose.translation() = eye;
  return pose;
}

// Distance along a ray (origin, direction with camera z = 1) to the surface, if it is hit.
using Surface = std::function<std::optional<double>(const Vec3d& origin, const Vec3d& ray)>;

inline Surface sphere(const Vec3d& center, double radius) {
  return [=](const Vec3d& origin, const Vec3d& ray) -> std::optional<double> {
    const Vec3d d = origin - center;
    const double a = ray.squaredNorm();
    const double b = ray.dot(d);
    const double root = b * b - a * (d.squaredNorm() - radius * radius);
    if (root < 0) return std::nullopt;
    const double t = (-b - std::sqrt(root)) / a;
    return t > 0 ? std::optional(t) : std::nullopt;
  };
}

// The plane of points with normal . x = offset.
inline Surface plane(const Vec3d& normal, double offset) {
  return [=](const Vec3d& origin, const Vec3d& ray) -> std::optional<double> {
    const double t = (offset - normal.dot(origin)) / normal.dot(ray);
    return t > 0 && std::isfinite(t) ? std::optional(t) : std::nullopt;
  };
}

inline Surface nearest_of(std::vector<Surface> surfaces) {
  return [surfaces = std::move(surfaces)](const Vec3d& origin, const Vec3d& ray) {
    std::optional<double> best;
    for (const Surface& s : surfaces) {
      const auto t = s(origin, ray);
      if (t && (!best || *t < *best)) best = t;
    }
    return best;
  };
}

// One camera for depth and colour. Colours vary smoothly with the pixel.
inline Frame render(const Surface& surface, const Camera& camera, const Pose& world_from_camera, std::int64_t index = 0) {
  Frame frame;
  frame.index = index;
  frame.depth_camera = frame.color_camera = camera;
  frame.world_from_camera = world_from_camera;
  Image<float> depth(camera.width, camera.height);
  Image<Rgb> color(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Vec3d ray = world_from_camera.linear() * back_project(camera, u, v, 1);
      depth(u, v) = static_cast<float>(surface(world_from_camera.translation(), ray).value_or(0));
      color(u, v) = {static_cast<std::uint8_t>(u % 256), static_cast<std::uint8_t>(v % 256),
                     static_cast<std::uint8_t>(80 + index % 100)};
    }
  }
  frame.depth = std::move(depth);
  frame.color = std::move(color);
  return frame;
}

// The three classes of the tests: stuff wall 1 and floor 2, thing chair 3; objects start at 4.
inline LabelSet test_labels() {
  return {"test",
          {{ClassId{1}, "wall", false, {200, 0, 0}},
           {ClassId{2}, "floor", false, {0, 200, 0}},
           {ClassId{3}, "chair", true, {0, 0, 200}}}};
}

// Left half of the image: a chair; right half: wall; a strip at the bottom without any label.
inline Segmentation halves(const Camera& camera) {
  Segmentation s{Image<std::uint16_t>(camera.width, camera.height),
                 {{ClassId{3}, 0.9F, {{ClassId{3}, 1.0F}}}, {ClassId{1}, 1.0F, {}}}};
  for (int v = 0; v < camera.height * 9 / 10; ++v) {
    for (int u = 0; u < camera.width; ++u) s.segment_at(u, v) = u < camera.width / 2 ? 1 : 2;
  }
  return s;
}

}  // namespace panoptic::test
