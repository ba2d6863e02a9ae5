// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/footprints.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>

namespace panoptic {
namespace {

// The direction of a thing's upright faces, if most of them stand along two directions at a right angle, as those of a box do.
// Four times the angle is the same for all of them.
std::optional<Vec2d> box_direction(const std::vector<LabelledPoint>& points) {
  constexpr double kMost = 0.5;
  std::complex<double> sum = 0;
  double total = 0;
  for (const LabelledPoint& p : points) {
    if (std::abs(p.normal.z()) > 0.5) continue;
    sum += p.area_m2 * std::polar(1.0, 4 * std::atan2(p.normal.y(), p.normal.x()));
    total += p.area_m2;
  }
  if (total <= 0 || std::abs(sum) < kMost * total) return std::nullopt;
  const double angle = std::arg(sum) / 4;
  return Vec2d(std::cos(angle), std::sin(angle));
}

Polygon box_along(const Polygon& hull, const Vec2d& axis) {
  Eigen::AlignedBox2d turned;
  for (const Vec2d& p : hull) turned.extend(Vec2d(axis.dot(p), quarter_turn(axis).dot(p)));
  const Vec2d center = axis * turned.center().x() + quarter_turn(axis) * turned.center().y();
  return corners({center, axis, turned.sizes()});
}

}  // namespace

std::vector<ThingFootprint> footprints(const LabelledSurface& surface) {
  constexpr std::size_t kFewest = 20;
  std::vector<ThingFootprint> all;
  for (const auto& [id, points] : surface.of_object) {
    if (points.size() < kFewest) continue;
    ThingFootprint print;
    print.object = id;
    print.class_id = surface.class_of.at(id);
    print.low_m = 1e9;
    print.high_m = -1e9;
    std::vector<Vec2d> from_above;
    for (const LabelledPoint& p : points) {
      from_above.emplace_back(p.at.head<2>());
      print.low_m = std::min(print.low_m, p.at.z());
      print.high_m = std::max(print.high_m, p.at.z());
    }
    const Polygon hull = convex_hull(std::move(from_above));
    const auto direction = box_direction(points);
    print.polygon = direction ? box_along(hull, *direction) : simplified(hull, surface.voxel_m / 2);
    if (signed_area(print.polygon) > 0) all.push_back(std::move(print));
  }
  return all;
}

}  // namespace panoptic
