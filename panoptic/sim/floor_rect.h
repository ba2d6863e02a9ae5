// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Footprints: rectangles that lie on the floor in any direction.
#pragma once

#include <Eigen/Geometry>

namespace panoptic {

struct FloorRect {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d half_m = Eigen::Vector2d::Zero();  // half its width (along `axis`) and half its depth
  Eigen::Vector2d axis = Eigen::Vector2d::UnitX();   // unit vector

  Eigen::Vector2d across() const { return {-axis.y(), axis.x()}; }
};

FloorRect rect_of(const Eigen::AlignedBox2d& box);
Eigen::AlignedBox2d bounds(const FloorRect& rect);
FloorRect grown(const FloorRect& rect, double margin_m);

// The distance of a point from the rectangle; 0 within.
double distance_m(const FloorRect& rect, const Eigen::Vector2d& point);

// False for rectangles that only touch, or overlap by less than the tolerance.
bool overlap(const FloorRect& a, const FloorRect& b, double tolerance_m = 1e-3);

}  // namespace panoptic
