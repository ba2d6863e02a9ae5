// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/surface_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "panoptic/base/nearest_points.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr std::array<double, 2> kThresholds_m = {0.05, 0.025};
constexpr double kSampleArea_m2 = 3e-4;
constexpr std::size_t kMinSamples = 1000;
constexpr std::size_t kChunk = 4096;

Vec3d corner(const Surface& surface, std::size_t triangle, std::size_t i) {
  return surface.positions[surface.triangles[triangle][i]].cast<double>();
}

double area_m2(const Surface& surface, std::size_t triangle) {
  const Vec3d a = corner(surface, triangle, 0);
  return (corner(surface, triangle, 1) - a).cross(corner(surface, triangle, 2) - a).norm() / 2;
}

double area_m2(const Surface& surface) {
  double sum = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) sum += area_m2(surface, t);
  return sum;
}

// The k-th number of a sequence that fills [0, 1) evenly (additive recurrence).
double spread(std::size_t k, double step) {
  const double value = 0.5 + static_cast<double>(k) * step;
  return value - std::floor(value);
}

std::size_t sample_count(double area_m2) {
  const double wanted = area_m2 / kSampleArea_m2;
  return std::clamp(
      wanted < static_cast<double>(SurfaceMetrics::kMaxSamples) ? static_cast<std::size_t>(wanted) : SurfaceMetrics::kMaxSamples,
      kMinSamples, SurfaceMetrics::kMaxSamples);
}

std::optional<double> share(std::size_t part, std::size_t all) {
  return all == 0 ? std::nullopt : std::optional(static_cast<double>(part) / static_cast<double>(all));
}

double harmonic_mean(double a, double b) { return a + b > 0 ? 2 * a * b / (a + b) : 0; }

}  // namespace

std::vector<Vec3f> sample_surface(const Surface& surface, std::size_t count) {
  const double total = area_m2(surface);
  std::vector<Vec3f> points;
  if (!(total > 0) || !std::isfinite(total)) return points;
  points.reserve(count);
  // Steps 1/g and 1/g^2 of the plastic number g: points of one large triangle lie evenly in it.
  constexpr double kStepU = 0.7548776662466927;
  constexpr double kStepV = 0.5698402909980532;
  double upto = 0;
  for (std::size_t t = 0; t < surface.triangles.size() && points.size() < count; ++t) {
    const double begin = upto;
    upto += area_m2(surface, t);
    const Vec3d a = corner(surface, t, 0);
    const Vec3d ab = corner(surface, t, 1) - a;
    const Vec3d ac = corner(surface, t, 2) - a;
    for (std::size_t k = points.size(); k < count; ++k) {
      if ((static_cast<double>(k) + 0.5) / static_cast<double>(count) * total >= upto || upto <= begin) break;
      double u = spread(k, kStepU);
      double v = spread(k, kStepV);
      if (u + v > 1) u = 1 - u, v = 1 - v;  // the other half of the parallelogram
      points.emplace_back((a + u * ab + v * ac).cast<float>());
    }
  }
  return points;
}

void SurfaceMetrics::count(const std::vector<Vec3f>& points, const std::vector<Vec3f>& others, Side& side) {
  side.points += points.size();
  if (others.empty()) return;
  const NearestPoints nearest(others);
  std::vector<double> distance_m(points.size());
  parallel_for((points.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    const std::size_t end = std::min(points.size(), (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i) distance_m[i] = nearest.nearest(points[i])->distance_m;
  });
  for (const double d : distance_m) {
    side.distance_sum_m += d;
    for (std::size_t t = 0; t < kThresholds_m.size(); ++t) side.near[t] += d < kThresholds_m[t] ? 1 : 0;
  }
  side.measured += points.size();
}

void SurfaceMetrics::add(const Surface& map, const Surface& truth) {
  const std::vector<Vec3f> map_points = sample_surface(map, sample_count(area_m2(map)));
  const std::vector<Vec3f> truth_points = sample_surface(truth, sample_count(area_m2(truth)));
  count(map_points, truth_points, map_);
  count(truth_points, map_points, truth_);
}

SurfaceScores SurfaceMetrics::scores() const {
  SurfaceScores scores;
  if (map_.measured > 0) scores.accuracy_m = map_.distance_sum_m / static_cast<double>(map_.measured);
  if (truth_.measured > 0) scores.completion_m = truth_.distance_sum_m / static_cast<double>(truth_.measured);
  for (std::size_t t = 0; t < kThresholds_m.size(); ++t) {
    ThresholdScores& at = scores.at[t];
    at.threshold_m = kThresholds_m[t];
    if (truth_.points == 0) continue;
    at.precision = share(map_.near[t], map_.points);
    at.recall = share(truth_.near[t], truth_.points);
    at.f_score = harmonic_mean(at.precision.value_or(0), *at.recall);
  }
  return scores;
}

}  // namespace panoptic
