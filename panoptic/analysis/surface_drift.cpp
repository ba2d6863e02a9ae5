// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/surface_drift.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "panoptic/analysis/surface_points.h"
#include "panoptic/map/surface_sampler.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr double kSpacing_m = 0.06;
constexpr double kSameWay = 0.9;  // the cosine of 26 degrees

// The signed distance, along the normal, from a point `at_m` before it to the surface there, if that faces the same way.
std::optional<double> surface_near(SurfaceSampler& sampler, const PlacedNormal& point, double at_m) {
  NearSurface near;
  if (!sampler.at(point.at + at_m * point.normal, near)) return std::nullopt;
  const double cosine = near.normal.cast<double>().dot(point.normal);
  if (cosine < kSameWay) return std::nullopt;
  return at_m - double{near.distance_m} / cosine;
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

}  // namespace

SurfaceShift shift_between(const VoxelMap& a, const VoxelMap& b) {
  const std::vector<PlacedNormal> points = surface_points(b, kSpacing_m);
  const double voxel_m = double{a.voxel_size_m()};
  constexpr double kNone = 2 * kFarthestShift_m;
  constexpr double kEdge = -1;  // not even b itself has a plane there
  std::vector<double> shifts(points.size(), kNone);
  parallel_for(points.size(), [&](std::size_t i) {
    SurfaceSampler sampler(a);
    SurfaceSampler sampler_of_b(b);
    const std::optional<double> own_m = surface_near(sampler_of_b, points[i], 0);
    if (!own_m) shifts[i] = kEdge;
    for (double off_m = 0; off_m <= kFarthestShift_m && shifts[i] == kNone; off_m += voxel_m) {
      for (const double side : {off_m, -off_m}) {
        if (const auto found = surface_near(sampler, points[i], side)) shifts[i] = std::min(shifts[i], std::abs(*found - *own_m));
      }
    }
  });
  std::erase(shifts, kEdge);
  const auto asked = static_cast<double>(std::max<std::size_t>(shifts.size(), 1));
  std::erase(shifts, kNone);
  return {static_cast<double>(shifts.size()) / asked, quantile(shifts, 0.5), quantile(shifts, 0.95)};
}

}  // namespace panoptic
