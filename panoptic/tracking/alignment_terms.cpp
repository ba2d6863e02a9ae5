// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/alignment_terms.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "panoptic/map/surface_sampler.h"
#include "panoptic/parallel.h"
#include "panoptic/tracking/projection.h"

namespace panoptic {
namespace {

constexpr std::size_t kParts = 8;  // summed one by one, then in order, so that threads do not matter
constexpr float kGreyNoise = 6;    // standard deviation of a difference in brightness, from one frame to another
constexpr float kSigmas = 3;
constexpr float kHidden = 0.05F;  // of its depth: a point that lies deeper than the reading there is hidden

void add(SurfaceSums& a, const SurfaceSums& b) {
  a.sums.add(b.sums);
  a.agreeing += b.agreeing;
}

void add(GreySums& a, const GreySums& b) {
  a.sums.add(b.sums);
  a.now += b.now;
  a.then += b.then;
  a.now_now += b.now_now;
  a.then_then += b.then_then;
  a.now_then += b.now_then;
}

template <typename Sums, typename Body>
Sums sum_in_parts(std::size_t count, const Body& body) {
  std::array<Sums, kParts> parts{};
  parallel_for(kParts, [&](std::size_t part) { body(parts[part], count * part / kParts, count * (part + 1) / kParts); });
  Sums all;
  for (const Sums& part : parts) add(all, part);
  return all;
}

// Cauchy's weight: 1 for small residuals.
float robust(float residual, float scale) {
  const float x = residual / scale;
  return 1 / (1 + x * x);
}

std::array<float, 6> with_moment(const Vec3f& force, const Vec3f& at) {
  const Vec3f moment = at.cross(force);
  return {force.x(), force.y(), force.z(), moment.x(), moment.y(), moment.z()};
}

void add_surface(SurfaceSums& sums, const DepthPoint& point, const NearSurface& surface, const Eigen::Matrix3f& camera_from_world,
                 float wide_m) {
  const float sigma_m = depth_noise_m(point.in_camera.z());
  const float weight = robust(surface.distance_m, std::max(wide_m, kSigmas * sigma_m)) / (sigma_m * sigma_m);
  sums.sums.add(with_moment(camera_from_world * surface.normal, point.in_camera), surface.distance_m, weight);
  if (std::abs(surface.distance_m) <= kSigmas * sigma_m) ++sums.agreeing;
}

// The look of one frame at the points of another, at one level of its pyramid.
struct GreyView {
  const AlignmentTask& task;
  const GreyLevel& level;
  Eigen::Isometry3f camera_from_reference;
  Eigen::Isometry3f color_from_depth;

  // The reading where a point is expected says that something stands before it, or that it is gone.
  bool is_hidden(const Vec3f& p) const {
    const Camera& c = task.frame.depth_camera;
    const Eigen::Vector2f pixel = project(c, p);
    const float u = pixel.x() + 0.5F;
    const float v = pixel.y() + 0.5F;
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(c.width) && v < static_cast<float>(c.height))) return false;
    const float z = task.frame.depth(static_cast<int>(u), static_cast<int>(v));
    return z > 0 && std::abs(z - p.z()) > kHidden * p.z();
  }

  void add(GreySums& sums, const GreyPoint& point, const Exposure& exposure) const {
    const Vec3f p = camera_from_reference * point.in_camera;
    const Vec3f q = color_from_depth * p;
    if (!(p.z() > task.range.min_m && q.z() > task.range.min_m)) return;
    const Eigen::Vector2f pixel = project(level.camera, q);
    if (!is_inside(level.grey, pixel.x(), pixel.y()) || is_hidden(p)) return;
    const GreySample s = sample(level.grey, pixel.x(), pixel.y());
    const auto fx = static_cast<float>(level.camera.fx);
    const auto fy = static_cast<float>(level.camera.fy);
    const Vec3f by_color(s.right * fx / q.z(), s.down * fy / q.z(),
                         -(s.right * fx * q.x() + s.down * fy * q.y()) / (q.z() * q.z()));
    const Vec3f by_camera = color_from_depth.linear().transpose() * by_color;
    const std::array<float, 6> motion = with_moment(-by_camera, p);
    const float residual = s.value - (1 + static_cast<float>(exposure.gain)) * point.grey - static_cast<float>(exposure.offset);
    const float weight = robust(residual, kSigmas * kGreyNoise) / (kGreyNoise * kGreyNoise);
    sums.sums.add({motion[0], motion[1], motion[2], motion[3], motion[4], motion[5], -point.grey, -1}, residual, weight);
    const double now = s.value;
    const double then = point.grey;
    sums.now += now;
    sums.then += then;
    sums.now_now += now * now;
    sums.then_then += then * then;
    sums.now_then += now * then;
  }
};

}  // namespace

SurfaceSums surface_terms(std::span<const DepthPoint> points, const VoxelMap& map, const Pose& world_from_camera, float wide_m) {
  const Eigen::Matrix3f camera_from_world = world_from_camera.linear().transpose().cast<float>();
  return sum_in_parts<SurfaceSums>(points.size(), [&](SurfaceSums& sums, std::size_t begin, std::size_t end) {
    SurfaceSampler sampler(map);
    NearSurface surface;
    for (const DepthPoint& point : points.subspan(begin, end - begin)) {
      if (sampler.at(world_from_camera * point.in_camera.cast<double>(), surface)) {
        add_surface(sums, point, surface, camera_from_world, wide_m);
      }
    }
  });
}

double GreySums::correlation() const {
  const double n = static_cast<double>(sums.count);
  const double spread = (n * now_now - now * now) * (n * then_then - then * then);
  return spread > 0 ? (n * now_then - now * then) / std::sqrt(spread) : 0;
}

GreySums grey_terms(const AlignmentTask& task, std::size_t level, const Pose& world_from_camera, const Exposure& exposure) {
  const std::vector<GreyPoint>& points = task.reference->levels[level];
  const GreyView view{task, task.pyramid[level], (world_from_camera.inverse() * task.reference->world_from_camera).cast<float>(),
                      task.frame.color_from_depth.cast<float>()};
  return sum_in_parts<GreySums>(points.size(), [&](GreySums& sums, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) view.add(sums, points[i], exposure);
  });
}

}  // namespace panoptic
