// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/figures.h"

#include <algorithm>
#include <cmath>

namespace panoptic {
namespace {

constexpr double kLength2 = 1e-12;  // limbs shorter than a micrometre are balls

double enter_ball(const Vec3d& center, double radius_m, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d from_center = origin - center;
  const double a = direction.squaredNorm();
  const double b = from_center.dot(direction);
  const double root2 = b * b - a * (from_center.squaredNorm() - radius_m * radius_m);
  return root2 < 0 ? 0 : std::max(0.0, (-b - std::sqrt(root2)) / a);
}

// Columns and rows that the limb may cover.
struct PixelRange {
  int u0 = 0;
  int u1 = 0;
  int v0 = 0;
  int v1 = 0;
};

PixelRange range_of(const Limb& in_camera, const Camera& camera) {
  constexpr double kNear_m = 0.05;
  PixelRange range{0, camera.width, 0, camera.height};
  const double r = in_camera.radius_m;
  const double nearest_m = std::min<double>(in_camera.from.z(), in_camera.to.z()) - r;
  if (std::max<double>(in_camera.from.z(), in_camera.to.z()) + r <= 0) return {};
  if (nearest_m < kNear_m) return range;  // beside the eye: it may cover anything
  double u_low = camera.width;
  double u_high = 0;
  double v_low = camera.height;
  double v_high = 0;
  for (const Vec3f& end : {in_camera.from, in_camera.to}) {
    for (const double z : {end.z() - r, end.z() + r}) {
      for (const double side : {-r, r}) {
        const double u = camera.fx * (end.x() + side) / z + camera.cx;
        const double v = camera.fy * (end.y() + side) / z + camera.cy;
        u_low = std::min(u_low, u);
        u_high = std::max(u_high, u);
        v_low = std::min(v_low, v);
        v_high = std::max(v_high, v);
      }
    }
  }
  const auto within = [](double value, int size) { return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size))); };
  return {within(u_low, camera.width), within(u_high + 2, camera.width), within(v_low, camera.height),
          within(v_high + 2, camera.height)};
}

}  // namespace

Eigen::AlignedBox3d box_of(const Figure& figure) {
  Eigen::AlignedBox3d box;
  for (const Limb& limb : figure.limbs) {
    for (const Vec3f& end : {limb.from, limb.to}) {
      box.extend(end.cast<double>() - Vec3d::Constant(limb.radius_m));
      box.extend(end.cast<double>() + Vec3d::Constant(limb.radius_m));
    }
  }
  return box;
}

double enter(const Limb& limb, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d from = limb.from.cast<double>();
  const Vec3d axis = limb.to.cast<double>() - from;
  const double radius_m = limb.radius_m;
  const double axis2 = axis.squaredNorm();
  if (axis2 < kLength2) return enter_ball(from, radius_m, origin, direction);
  const Vec3d offset = origin - from;
  const double along_ray = axis.dot(direction);
  const double along = axis.dot(offset);
  // The pipe around the whole line, in coordinates that are scaled by the axis' squared length.
  const double a = axis2 * direction.squaredNorm() - along_ray * along_ray;
  const double b = axis2 * offset.dot(direction) - along * along_ray;
  const double c = axis2 * (offset.squaredNorm() - radius_m * radius_m) - along * along;
  const double root2 = b * b - a * c;
  if (root2 < 0) return 0;
  if (a > kLength2 * axis2) {
    const double distance = (-b - std::sqrt(root2)) / a;
    const double at = along + distance * along_ray;
    if (at > 0 && at < axis2) return std::max(0.0, distance);
    return enter_ball(at <= 0 ? from : Vec3d(from + axis), radius_m, origin, direction);
  }
  const double first = enter_ball(from, radius_m, origin, direction);
  const double second = enter_ball(from + axis, radius_m, origin, direction);
  return first > 0 && second > 0 ? std::min(first, second) : std::max(first, second);
}

namespace {

// Draws a limb, given in the camera's frame, over what is behind it. `name`: of its figure and of itself.
void draw_limb(const Limb& limb, const FigureLayer::Pixel& name, const Camera& camera, FigureLayer& layer) {
  const PixelRange range = range_of(limb, camera);
  for (int v = range.v0; v < range.v1; ++v) {
    for (int u = range.u0; u < range.u1; ++u) {
      const auto depth_m = static_cast<float>(enter(limb, Vec3d::Zero(), back_project(camera, u, v, 1)));
      FigureLayer::Pixel& pixel = layer.pixels(u, v);
      if (depth_m <= 0 || (pixel.depth_m > 0 && pixel.depth_m <= depth_m)) continue;
      pixel = name;
      pixel.depth_m = depth_m;
    }
  }
}

}  // namespace

FigureLayer draw_figures(const std::vector<Figure>& figures, const Camera& camera, const Pose& world_from_camera) {
  FigureLayer layer{Image<FigureLayer::Pixel>(camera.width, camera.height)};
  const Eigen::Isometry3f camera_from_world = world_from_camera.inverse().cast<float>();
  for (std::size_t f = 0; f < figures.size(); ++f) {
    for (std::size_t l = 0; l < figures[f].limbs.size(); ++l) {
      Limb limb = figures[f].limbs[l];
      limb.from = camera_from_world * limb.from;
      limb.to = camera_from_world * limb.to;
      draw_limb(limb, {0, static_cast<std::uint16_t>(f), static_cast<std::uint16_t>(l)}, camera, layer);
    }
  }
  return layer;
}

}  // namespace panoptic
