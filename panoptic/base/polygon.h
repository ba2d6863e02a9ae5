// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Polygons in a plane: corners in order, the last joined to the first, none twice. Metres.
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace panoptic {

using Vec2d = Eigen::Vector2d;
using Polygon = std::vector<Vec2d>;

inline double cross(const Vec2d& a, const Vec2d& b) { return a.x() * b.y() - a.y() * b.x(); }
inline Vec2d quarter_turn(const Vec2d& v) { return {-v.y(), v.x()}; }  // to the left

// Positive if the corners run counter-clockwise.
double signed_area(const Polygon& polygon);
// The middle of the area; the mean of the corners if there is none.
Vec2d centroid(const Polygon& polygon);
bool contains(const Polygon& polygon, const Vec2d& point);

// Counter-clockwise, without collinear points.
Polygon convex_hull(std::vector<Vec2d> points);

// A rectangle in any direction; `axis` is a unit vector along the longer side.
struct FlatBox {
  Vec2d center = Vec2d::Zero();
  Vec2d axis = Vec2d::UnitX();
  Vec2d size_m = Vec2d::Zero();  // along the axis and across it
};
// The smallest rectangle around a convex polygon.
FlatBox smallest_box(const Polygon& hull);
Polygon corners(const FlatBox& box);  // counter-clockwise

// The polygon without corners that are nearer than the tolerance to the line of those that stay (Douglas and Peucker).
Polygon simplified(const Polygon& polygon, double tolerance_m);

// The area of the intersection over that of the union; 0 if both are empty. Exact along x, in 2000 steps along y.
double intersection_over_union(const Polygon& a, const Polygon& b);

}  // namespace panoptic
