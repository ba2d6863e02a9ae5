// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/floor_rect.h"

#include <cmath>

namespace panoptic {
namespace {

// Half the shadow that a rectangle throws onto a line of that direction.
double half_shadow_m(const FloorRect& rect, const Eigen::Vector2d& direction) {
  return rect.half_m.x() * std::abs(rect.axis.dot(direction)) + rect.half_m.y() * std::abs(rect.across().dot(direction));
}

}  // namespace

FloorRect rect_of(const Eigen::AlignedBox2d& box) { return {box.center(), box.sizes() / 2, Eigen::Vector2d::UnitX()}; }

Eigen::AlignedBox2d bounds(const FloorRect& rect) {
  const Eigen::Vector2d half_m(half_shadow_m(rect, Eigen::Vector2d::UnitX()), half_shadow_m(rect, Eigen::Vector2d::UnitY()));
  return {rect.center - half_m, rect.center + half_m};
}

FloorRect grown(const FloorRect& rect, double margin_m) {
  return {rect.center, rect.half_m + Eigen::Vector2d::Constant(margin_m), rect.axis};
}

double distance_m(const FloorRect& rect, const Eigen::Vector2d& point) {
  const Eigen::Vector2d offset = point - rect.center;
  const Eigen::Vector2d beyond(std::abs(offset.dot(rect.axis)) - rect.half_m.x(),
                               std::abs(offset.dot(rect.across())) - rect.half_m.y());
  return beyond.cwiseMax(0).norm();
}

bool overlap(const FloorRect& a, const FloorRect& b, double tolerance_m) {
  const Eigen::Vector2d offset = b.center - a.center;
  // Two rectangles are apart exactly if their shadows on one of the four directions of their sides are.
  for (const Eigen::Vector2d& direction : {a.axis, a.across(), b.axis, b.across()}) {
    const double gap_m = std::abs(offset.dot(direction)) - half_shadow_m(a, direction) - half_shadow_m(b, direction);
    if (gap_m > -tolerance_m) return false;
  }
  return true;
}

}  // namespace panoptic
