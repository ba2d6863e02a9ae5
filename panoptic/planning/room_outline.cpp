// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "panoptic/planning/rooms.h"

namespace panoptic {
namespace {

constexpr double kTurn = 0.3;  // sine of 17 degrees

// A line through an edge of the polygon, or through the wall that took the edge's place.
struct EdgeLine {
  Vec2d start = Vec2d::Zero();  // of the edge itself
  Vec2d end = Vec2d::Zero();
  Vec2d point = Vec2d::Zero();  // on the line
  Vec2d along = Vec2d::UnitX();
  bool is_wall = false;

  double length_m() const { return (end - start).norm(); }
};

std::optional<EdgeLine> wall_of(const EdgeLine& edge, const std::vector<WallLine>& walls) {
  constexpr double kParallel = 0.97;  // cosine of 14 degrees
  constexpr double kNear_m = 0.2;
  constexpr double kBeyond_m = 0.3;
  const Vec2d inward = quarter_turn(edge.along);
  const Vec2d middle = (edge.start + edge.end) / 2;
  std::optional<EdgeLine> best;
  double nearest_m = kNear_m;
  for (const WallLine& wall : walls) {
    const double distance_m = std::abs(wall.normal.dot(middle - wall.from));
    if (wall.normal.dot(inward) < kParallel || distance_m >= nearest_m) continue;
    const Vec2d along = -quarter_turn(wall.normal);
    const double a = along.dot(wall.from - middle);
    const double b = along.dot(wall.to - middle);
    const double reach_m = edge.length_m() / 2 + kBeyond_m;
    if (std::min(a, b) > reach_m || std::max(a, b) < -reach_m) continue;
    nearest_m = distance_m;
    best = edge;
    best->point = wall.from;
    best->along = along;
    best->is_wall = true;
  }
  return best;
}

bool is_same_line(const EdgeLine& a, const EdgeLine& b) {
  constexpr double kSame_m = 0.05;
  return std::abs(cross(a.along, b.along)) < 0.1 && std::abs(cross(a.along, b.point - a.point)) < kSame_m;
}

Vec2d meeting_of(const EdgeLine& a, const EdgeLine& b) {
  return a.point + a.along * cross(b.point - a.point, b.along) / cross(a.along, b.along);
}

// Whether two walls meet, or are one, near the ends of the edges that they took the place of.
bool belong_together(const EdgeLine& a, const EdgeLine& b) {
  constexpr double kHidden_m = 1.0;  // what stands in a corner or before a wall
  if (is_same_line(a, b)) return (b.start - a.end).norm() < 2 * kHidden_m;
  if (std::abs(cross(a.along, b.along)) < kTurn) return false;
  const Vec2d corner = meeting_of(a, b);
  return (corner - a.end).norm() < kHidden_m && (corner - b.start).norm() < kHidden_m;
}

// Without the edges between two walls that belong together: things that stand there made them.
std::vector<EdgeLine> without_detours(std::vector<EdgeLine> edges) {
  const auto first = std::find_if(edges.begin(), edges.end(), [](const EdgeLine& e) { return e.is_wall; });
  if (first == edges.end()) return edges;
  std::rotate(edges.begin(), first, edges.end());
  std::vector<EdgeLine> kept;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].is_wall) {
      kept.push_back(edges[i]);
      continue;
    }
    std::size_t next = i;
    while (next < edges.size() && !edges[next].is_wall) ++next;
    const EdgeLine& wall = next < edges.size() ? edges[next] : edges.front();
    if (!belong_together(kept.back(), wall))
      kept.insert(kept.end(), edges.begin() + static_cast<std::ptrdiff_t>(i), edges.begin() + static_cast<std::ptrdiff_t>(next));
    i = next - 1;
  }
  return kept;
}

// Neighbours on one line become one.
std::vector<EdgeLine> joined_edges(const std::vector<EdgeLine>& edges) {
  std::vector<EdgeLine> kept;
  for (const EdgeLine& edge : edges) {
    if (!kept.empty() && is_same_line(kept.back(), edge)) {
      kept.back().end = edge.end;
    } else {
      kept.push_back(edge);
    }
  }
  while (kept.size() > 1 && is_same_line(kept.back(), kept.front())) {
    kept.front().start = kept.back().start;
    kept.pop_back();
  }
  return kept;
}

Vec2d onto(const EdgeLine& line, const Vec2d& p) { return line.point + line.along * line.along.dot(p - line.point); }

}  // namespace

Polygon on_walls(const Polygon& polygon, const std::vector<WallLine>& walls) {
  constexpr double kShortest_m = 0.2;
  constexpr double kMostChange = 0.15;  // of the area
  std::vector<EdgeLine> edges;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    EdgeLine edge{polygon[i], polygon[(i + 1) % polygon.size()], polygon[i], Vec2d::UnitX(), false};
    if (edge.length_m() <= 0) continue;
    edge.along = (edge.end - edge.start).normalized();
    const auto wall = edge.length_m() >= kShortest_m ? wall_of(edge, walls) : std::nullopt;
    edges.push_back(wall.value_or(edge));
  }
  edges = joined_edges(without_detours(std::move(edges)));
  Polygon result;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const EdgeLine& edge = edges[i];
    const EdgeLine& next = edges[(i + 1) % edges.size()];
    if (std::abs(cross(edge.along, next.along)) > kTurn) {
      result.push_back(meeting_of(edge, next));
    } else {
      result.push_back(onto(edge, edge.end));
      result.push_back(onto(next, next.start));
    }
  }
  const double before_m2 = signed_area(polygon);
  const bool is_sound = result.size() >= 3 && std::abs(signed_area(result) - before_m2) < kMostChange * before_m2;
  return is_sound ? result : polygon;
}

}  // namespace panoptic
