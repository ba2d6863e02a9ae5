// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/ways.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace panoptic {
namespace {

constexpr double kComfort_m = 0.6;  // nearer to furniture than this the way is dearer
constexpr int kSmoothings = 60;

}  // namespace

WaysFrom ways_from(const ClearanceMap& clearance, int start, double body_m) {
  const auto count = static_cast<std::size_t>(clearance.width()) * static_cast<std::size_t>(clearance.height());
  WaysFrom ways{std::vector<float>(count, std::numeric_limits<float>::infinity()), std::vector<std::int32_t>(count, -1)};
  using Entry = std::pair<float, std::int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  ways.cost[static_cast<std::size_t>(start)] = 0;
  open.emplace(0.0F, start);
  while (!open.empty()) {
    const auto [cost, cell] = open.top();
    open.pop();
    if (cost > ways.cost[static_cast<std::size_t>(cell)]) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = cell % clearance.width() + dx;
        const int y = cell / clearance.width() + dy;
        if (x < 0 || y < 0 || x >= clearance.width() || y >= clearance.height()) continue;
        const int next = y * clearance.width() + x;
        if (clearance[next] < body_m) continue;
        const double step = dx != 0 && dy != 0 ? 1.41421356 : 1.0;
        const double dearness = 1 + 4 * std::max(0.0, kComfort_m - clearance[next]);
        const float total = cost + static_cast<float>(step * dearness);
        if (total >= ways.cost[static_cast<std::size_t>(next)]) continue;
        ways.cost[static_cast<std::size_t>(next)] = total;
        ways.previous[static_cast<std::size_t>(next)] = cell;
        open.emplace(total, next);
      }
    }
  }
  return ways;
}

std::vector<Eigen::Vector2d> smooth_way(const ClearanceMap& clearance, const WaysFrom& ways, int to, double body_m,
                                        double step_m) {
  std::vector<Eigen::Vector2d> points;
  for (std::int32_t at = to; at >= 0; at = ways.previous[static_cast<std::size_t>(at)]) points.push_back(clearance.middle(at));
  std::reverse(points.begin(), points.end());
  for (int round = 0; round < kSmoothings; ++round) {
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      const Eigen::Vector2d moved = 0.5 * points[i] + 0.25 * (points[i - 1] + points[i + 1]);
      if (clearance.at(moved) >= std::min(body_m, clearance.at(points[i]))) points[i] = moved;
    }
  }
  std::vector<Eigen::Vector2d> even = {points.front()};
  double left_m = step_m;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Eigen::Vector2d leg = points[i + 1] - points[i];
    const double length_m = leg.norm();
    double done_m = 0;
    while (length_m - done_m >= left_m) {
      done_m += left_m;
      even.emplace_back(points[i] + leg * (done_m / length_m));
      left_m = step_m;
    }
    left_m -= length_m - done_m;
  }
  if ((points.back() - even.back()).norm() > 1e-6) even.push_back(points.back());
  return even;
}

}  // namespace panoptic
