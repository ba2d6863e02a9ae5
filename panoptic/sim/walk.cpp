// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "panoptic/sim/ways.h"

namespace panoptic {
namespace {

constexpr double kEye_m = 1.45;
constexpr double kSpacing_m = 0.35;  // between places that are considered for looking around
constexpr double kEnough = 2.0;      // what a further stop must show, in weights of sights
constexpr int kMostStops = 6;        // per room
constexpr int kSmoothings = 150;

// Places of a room that together see its sights: the best one, then the one that adds most, and so on.
std::vector<int> stops_in(const Home& home, std::uint32_t room, const ClearanceMap& clearance, const std::vector<Sight>& sights,
                          const WaysFrom& ways) {
  std::vector<int> places;
  const Eigen::AlignedBox2d& floor = home.rooms[room].floor;
  for (double y = floor.min().y() + kBody_m; y < floor.max().y(); y += kSpacing_m) {
    for (double x = floor.min().x() + kBody_m; x < floor.max().x(); x += kSpacing_m) {
      const int cell = clearance.cell_at({x, y});
      if (clearance[cell] > kBody_m + 0.03 && std::isfinite(ways.cost[static_cast<std::size_t>(cell)])) places.push_back(cell);
    }
  }
  std::vector<char> is_seen(sights.size(), 0);
  std::vector<int> stops;
  while (static_cast<int>(stops.size()) < kMostStops) {
    int best = -1;
    double best_gain = kEnough;
    for (const int place : places) {
      const Eigen::Vector2d at = clearance.middle(place);
      double gain = 0;
      for (std::size_t i = 0; i < sights.size(); ++i) {
        if (sights[i].room == room && is_seen[i] == 0 && is_in_reach(sights[i], {at.x(), at.y(), kEye_m}))
          gain += sights[i].weight;
      }
      if (gain <= best_gain) continue;
      best_gain = gain;
      best = place;
    }
    if (best < 0) break;
    stops.push_back(best);
    const Eigen::Vector2d at = clearance.middle(best);
    for (std::size_t i = 0; i < sights.size(); ++i) {
      if (sights[i].room == room && is_in_reach(sights[i], {at.x(), at.y(), kEye_m})) is_seen[i] = 1;
    }
  }
  return stops;
}

// Grows the line of cells from one stop to the next.
class Line {
 public:
  Line(const ClearanceMap& clearance, int start)
      : clearance_(clearance), ways_(ways_from(clearance, start, kBody_m)), cells_{start} {}

  double cost_to(int cell) const { return ways_.cost[static_cast<std::size_t>(cell)]; }
  const std::vector<std::int32_t>& cells() const { return cells_; }

  void go_to(int cell) {
    if (!std::isfinite(cost_to(cell))) return;
    std::vector<std::int32_t> leg;
    for (std::int32_t at = cell; at != cells_.back(); at = ways_.previous[static_cast<std::size_t>(at)]) leg.push_back(at);
    cells_.insert(cells_.end(), leg.rbegin(), leg.rend());
    ways_ = ways_from(clearance_, cell, kBody_m);
  }

 private:
  const ClearanceMap& clearance_;
  WaysFrom ways_;
  std::vector<std::int32_t> cells_;
};

// Goes to the nearest stop of the room, then on to the next, then into the rooms behind its other doors.
struct Tour {
  const Home& home;
  const ClearanceMap& clearance;
  std::vector<std::vector<int>> stops;  // per room
  Line line;
  std::vector<std::size_t> stop_at;  // positions in the line
  std::vector<char> is_visited;

  void visit(std::uint32_t room) {
    is_visited[room] = 1;
    std::vector<int> left = stops[room];
    while (!left.empty()) {
      const auto nearest =
          std::min_element(left.begin(), left.end(), [&](int a, int b) { return line.cost_to(a) < line.cost_to(b); });
      line.go_to(*nearest);
      stop_at.push_back(line.cells().size() - 1);
      left.erase(nearest);
    }
    while (const Doorway* door = next_door(room)) {
      const std::uint32_t behind = door->room_a == room ? door->room_b : door->room_a;
      line.go_to(clearance.cell_at(door->center));
      visit(behind);
    }
  }

  const Doorway* next_door(std::uint32_t room) const {
    const Doorway* best = nullptr;
    for (const Doorway& doorway : home.doorways) {
      const bool leads_on = (doorway.room_a == room && is_visited[doorway.room_b] == 0) ||
                            (doorway.room_b == room && is_visited[doorway.room_a] == 0);
      if (!leads_on) continue;
      if (best == nullptr || line.cost_to(clearance.cell_at(doorway.center)) < line.cost_to(clearance.cell_at(best->center)))
        best = &doorway;
    }
    return best;
  }
};

// Each point moves towards the middle of its neighbours, unless that brings it too near to something; stops stay.
void smooth(const ClearanceMap& clearance, const std::vector<char>& is_fixed, std::vector<Eigen::Vector2d>& points) {
  for (int round = 0; round < kSmoothings; ++round) {
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      if (is_fixed[i] != 0) continue;
      const Eigen::Vector2d moved = 0.5 * points[i] + 0.25 * (points[i - 1] + points[i + 1]);
      if (clearance.at(moved) >= std::min(kBody_m, clearance.at(points[i]))) points[i] = moved;
    }
  }
}

Walk resample(const std::vector<Eigen::Vector2d>& points, const std::vector<std::size_t>& stops) {
  Walk walk;
  walk.points.push_back(points.front());
  double left_m = kStep_m;  // to the next point of the walk
  std::size_t stop = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    for (; stop < stops.size() && stops[stop] == i; ++stop) walk.look_around.push_back(walk.points.size() - 1);
    const Eigen::Vector2d leg = points[i + 1] - points[i];
    const double length_m = leg.norm();
    double done_m = 0;
    while (length_m - done_m >= left_m && length_m > 0) {
      done_m += left_m;
      walk.points.emplace_back(points[i] + leg * (done_m / length_m));
      left_m = kStep_m;
    }
    left_m -= length_m - done_m;
  }
  for (; stop < stops.size(); ++stop) walk.look_around.push_back(walk.points.size() - 1);
  return walk;
}

// The free spot of the first room that lies nearest to its middle.
int start_of(const Home& home, const ClearanceMap& clearance) {
  int best = 0;
  double best_m = std::numeric_limits<double>::infinity();
  for (int cell = 0; cell < clearance.width() * clearance.height(); ++cell) {
    const Eigen::Vector2d middle = clearance.middle(cell);
    if (clearance[cell] < kBody_m + 0.03 || !home.rooms[0].floor.contains(middle)) continue;
    const double far_m = (middle - home.rooms[0].floor.center()).norm();
    if (far_m >= best_m) continue;
    best_m = far_m;
    best = cell;
  }
  return best;
}

}  // namespace

Walk plan_walk(const Home& home, const ClearanceMap& clearance, const std::vector<Sight>& sights) {
  const int start = start_of(home, clearance);
  const WaysFrom ways = ways_from(clearance, start, kBody_m);
  std::vector<std::vector<int>> stops;
  for (std::uint32_t room = 0; room < home.rooms.size(); ++room) stops.push_back(stops_in(home, room, clearance, sights, ways));
  Tour tour{home, clearance, std::move(stops), Line(clearance, start), {}, std::vector<char>(home.rooms.size(), 0)};
  tour.visit(0);
  tour.line.go_to(start);
  std::vector<Eigen::Vector2d> points;
  for (const std::int32_t cell : tour.line.cells()) points.push_back(clearance.middle(cell));
  std::vector<char> is_fixed(points.size(), 0);
  for (const std::size_t stop : tour.stop_at) is_fixed[stop] = 1;
  smooth(clearance, is_fixed, points);
  return resample(points, tour.stop_at);
}

}  // namespace panoptic
