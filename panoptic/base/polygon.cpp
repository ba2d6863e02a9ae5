// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/polygon.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace panoptic {
namespace {

// Where a line of constant y crosses the polygon's edges: inside it between the first and the second, and so on.
std::vector<double> crossings(const Polygon& polygon, double y) {
  std::vector<double> at;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2d& a = polygon[i];
    const Vec2d& b = polygon[(i + 1) % polygon.size()];
    if ((a.y() <= y) == (b.y() <= y)) continue;
    at.push_back(a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y()));
  }
  std::sort(at.begin(), at.end());
  return at;
}

double length_of(const std::vector<double>& intervals) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < intervals.size(); i += 2) length += intervals[i + 1] - intervals[i];
  return length;
}

double common_length(const std::vector<double>& a, const std::vector<double>& b) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < a.size(); i += 2) {
    for (std::size_t j = 0; j + 1 < b.size(); j += 2) {
      length += std::max(0.0, std::min(a[i + 1], b[j + 1]) - std::max(a[i], b[j]));
    }
  }
  return length;
}

double distance_to_line(const Vec2d& point, const Vec2d& from, const Vec2d& to) {
  const Vec2d along = to - from;
  const double length = along.norm();
  return length > 0 ? std::abs(cross(along, point - from)) / length : (point - from).norm();
}

// Marks the corners between `first` and `last` that stay.
void keep_far_corners(const Polygon& polygon, std::pair<std::size_t, std::size_t> range, double tolerance_m,
                      std::vector<char>& stays) {
  const auto [first, last] = range;
  std::size_t farthest = first;
  double far_m = tolerance_m;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double distance_m = distance_to_line(polygon[i], polygon[first], polygon[last % polygon.size()]);
    if (distance_m > far_m) far_m = distance_m, farthest = i;
  }
  if (farthest == first) return;
  stays[farthest] = 1;
  keep_far_corners(polygon, {first, farthest}, tolerance_m, stays);
  keep_far_corners(polygon, {farthest, last}, tolerance_m, stays);
}

}  // namespace

double signed_area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return twice / 2;
}

Vec2d centroid(const Polygon& polygon) {
  Vec2d mean = Vec2d::Zero();
  for (const Vec2d& corner : polygon) mean += corner / static_cast<double>(polygon.size());
  Vec2d sum = Vec2d::Zero();
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2d a = polygon[i] - mean;
    const Vec2d b = polygon[(i + 1) % polygon.size()] - mean;
    twice += cross(a, b);
    sum += cross(a, b) * (a + b) / 3;
  }
  return std::abs(twice) > 1e-12 ? Vec2d(mean + sum / twice) : mean;
}

bool contains(const Polygon& polygon, const Vec2d& point) {
  bool inside = false;
  for (const double x : crossings(polygon, point.y())) inside = inside != (x <= point.x());
  return inside;
}

// Monotone chain.
Polygon convex_hull(std::vector<Vec2d> points) {
  if (points.size() < 3) return points;
  std::sort(points.begin(), points.end(),
            [](const Vec2d& a, const Vec2d& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  Polygon hull;
  const auto append = [&](const Vec2d& point, std::size_t keep) {
    while (hull.size() > keep && cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0) hull.pop_back();
    hull.push_back(point);
  };
  for (const Vec2d& point : points) append(point, 1);
  const std::size_t lower = hull.size();
  for (auto point = points.rbegin() + 1; point < points.rend(); ++point) append(*point, lower);
  hull.pop_back();
  return hull;
}

FlatBox smallest_box(const Polygon& hull) {
  FlatBox best;
  if (hull.empty()) return best;
  best.center = hull[0];
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2d edge = hull[(i + 1) % hull.size()] - hull[i];
    if (edge.norm() <= 0) continue;
    const Vec2d along = edge.normalized();
    const Vec2d across = quarter_turn(along);
    Eigen::AlignedBox2d turned;
    for (const Vec2d& point : hull) turned.extend(Vec2d(along.dot(point), across.dot(point)));
    const Vec2d size = turned.sizes();
    if (size.prod() >= least) continue;
    least = size.prod();
    best.center = along * turned.center().x() + across * turned.center().y();
    best.axis = size.x() >= size.y() ? along : across;
    best.size_m = {size.maxCoeff(), size.minCoeff()};
  }
  return best;
}

Polygon corners(const FlatBox& box) {
  const Vec2d u = box.axis * box.size_m.x() / 2;
  const Vec2d v = quarter_turn(box.axis) * box.size_m.y() / 2;
  return {box.center - u - v, box.center + u - v, box.center + u + v, box.center - u + v};
}

Polygon simplified(const Polygon& polygon, double tolerance_m) {
  if (polygon.size() < 4) return polygon;
  // The two corners that are farthest apart along the longest extent stay in any case.
  const auto by = [](int axis) { return [axis](const Vec2d& a, const Vec2d& b) { return a[axis] < b[axis]; }; };
  const auto [low_x, high_x] = std::minmax_element(polygon.begin(), polygon.end(), by(0));
  const auto [low_y, high_y] = std::minmax_element(polygon.begin(), polygon.end(), by(1));
  const bool is_wide = high_x->x() - low_x->x() >= high_y->y() - low_y->y();
  const auto start = is_wide ? low_x : low_y;
  const auto end = is_wide ? high_x : high_y;
  Polygon turned(start, polygon.end());
  turned.insert(turned.end(), polygon.begin(), start);
  const auto count = static_cast<std::ptrdiff_t>(polygon.size());
  const auto opposite = static_cast<std::size_t>((end - start + count) % count);
  std::vector<char> stays(turned.size(), 0);
  stays[0] = stays[opposite] = 1;
  keep_far_corners(turned, {0, opposite}, tolerance_m, stays);
  keep_far_corners(turned, {opposite, turned.size()}, tolerance_m, stays);
  Polygon result;
  for (std::size_t i = 0; i < turned.size(); ++i) {
    if (stays[i] != 0) result.push_back(turned[i]);
  }
  return result;
}

double intersection_over_union(const Polygon& a, const Polygon& b) {
  constexpr int kRows = 2000;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Polygon* polygon : std::array{&a, &b}) {
    for (const Vec2d& corner : *polygon) low = std::min(low, corner.y()), high = std::max(high, corner.y());
  }
  double in_a = 0;
  double in_b = 0;
  double in_both = 0;
  for (int row = 0; row < kRows && low < high; ++row) {
    const double y = low + (high - low) * (row + 0.5) / kRows;
    const std::vector<double> of_a = crossings(a, y);
    const std::vector<double> of_b = crossings(b, y);
    in_a += length_of(of_a);
    in_b += length_of(of_b);
    in_both += common_length(of_a, of_b);
  }
  const double in_any = in_a + in_b - in_both;
  return in_any > 0 ? in_both / in_any : 0;
}

}  // namespace panoptic
