// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/seats.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "panoptic/planning/level_patch.h"

namespace panoptic {
namespace {

// The hollow of the knee of adults is 35 to 49 cm above the floor (5 % of women to 95 % of men, DIN 33402-2). Low lounge chairs
// are 10 cm lower; who perches on a high stool sits 15 cm higher.
constexpr HeightSpan kSeatBand{0.25, 0.65};
constexpr double kSmallestSeat_m2 = 0.04;  // 20 by 20 cm
constexpr double kPlaceWidth_m = 0.55;     // shoulders and elbows of one person
constexpr double kLowestBack_m = 0.12;     // above the seat: less gives no support

Vec2d flat(const Vec3d& v) { return v.head<2>(); }

// The points of the upper part of what rises above a seat: there arm rests, which are lower than a back rest, play no part.
std::vector<Vec2d> back_points(const std::vector<LabelledPoint>& points, double seat_m) {
  constexpr double kUpperPart = 0.6;
  std::vector<double> above;
  for (const LabelledPoint& p : points) {
    if (p.at.z() > seat_m + kLowestBack_m / 2) above.push_back(p.at.z());
  }
  if (above.size() < 10) return {};
  const auto top = above.begin() + static_cast<std::ptrdiff_t>(above.size() * 98 / 100);
  std::nth_element(above.begin(), top, above.end());
  if (*top < seat_m + kLowestBack_m) return {};
  const double from_m = seat_m + kUpperPart * (*top - seat_m);
  std::vector<Vec2d> back;
  for (const LabelledPoint& p : points) {
    if (p.at.z() >= from_m) back.push_back(flat(p.at));
  }
  return back;
}

struct FlatSpread {
  Vec2d mean = Vec2d::Zero();
  Vec2d long_axis = Vec2d::UnitX();
  double ratio = 1;  // of the standard deviations
};

FlatSpread spread_of(const std::vector<Vec2d>& points) {
  FlatSpread spread;
  for (const Vec2d& p : points) spread.mean += p / static_cast<double>(points.size());
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Vec2d& p : points) covariance += (p - spread.mean) * (p - spread.mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  spread.long_axis = solver.eigenvectors().col(1);
  spread.ratio = std::sqrt(solver.eigenvalues()[1] / std::max(solver.eigenvalues()[0], 1e-12));
  return spread;
}

// Away from the back rest: at a right angle to one that is clearly wider than deep, else from its middle to that of the seat.
std::optional<Vec2d> away_from_back(const std::vector<LabelledPoint>& points, const LevelPatch& seat) {
  constexpr double kClearly = 2;
  const std::vector<Vec2d> back = back_points(points, seat.center.z());
  if (back.size() < 10) return std::nullopt;
  const FlatSpread spread = spread_of(back);
  const Vec2d forward = flat(seat.center) - spread.mean;
  if (forward.norm() < 1e-6) return std::nullopt;
  if (spread.ratio < kClearly) return forward.normalized();
  const Vec2d across = quarter_turn(spread.long_axis);
  return across.dot(forward) >= 0 ? across : Vec2d(-across);
}

Vec2d middle_of(const TableTop& table) {
  Polygon polygon;
  for (const Vec3d& corner : table.polygon) polygon.push_back(flat(corner));
  return centroid(polygon);
}

Vec2d away_from_all(const Vec2d& seat, const std::vector<TableTop>& tables, const std::vector<LabelledPoint>& wall) {
  constexpr double kReach_m = 1;
  Vec2d facing = Vec2d::UnitX();
  double nearest_m = kReach_m;
  for (const TableTop& table : tables) {
    const Vec2d to_table = middle_of(table) - seat;
    if (to_table.norm() < nearest_m && to_table.norm() > 1e-6) nearest_m = to_table.norm(), facing = to_table.normalized();
  }
  if (nearest_m < kReach_m) return facing;
  double wall_m = 1e9;
  for (const LabelledPoint& p : wall) {
    const Vec2d from_wall = seat - flat(p.at);
    if (from_wall.norm() < wall_m && from_wall.norm() > 1e-6) wall_m = from_wall.norm(), facing = from_wall.normalized();
  }
  return facing;
}

// Places beside each other across the direction that people face.
std::vector<Seat> places_on(const LevelPatch& patch, const Vec2d& facing) {
  const Vec2d side = quarter_turn(facing);
  double low_m = 1e9;
  double high_m = -1e9;
  for (const Vec3d& p : patch.points) {
    low_m = std::min(low_m, side.dot(flat(p)));
    high_m = std::max(high_m, side.dot(flat(p)));
  }
  const int places = std::max(1, static_cast<int>((high_m - low_m) / kPlaceWidth_m));
  std::vector<Seat> seats;
  for (int i = 0; i < places; ++i) {
    const double across_m = low_m + (high_m - low_m) * (i + 0.5) / places;
    const Vec2d at = side * across_m + facing * facing.dot(flat(patch.center));
    Seat seat;
    seat.position = {at.x(), at.y(), patch.center.z()};
    seat.normal = patch.normal;
    seat.facing = {facing.x(), facing.y(), 0};
    seat.height_m = patch.center.z();
    seats.push_back(seat);
  }
  return seats;
}

// A head board, or pillows against a wall, rise above the end where the head lies.
bool head_is_behind(const std::vector<LabelledPoint>& points, const LevelPatch& patch, const FlatBox& box) {
  double balance = 0;
  for (const LabelledPoint& p : points) {
    if (p.at.z() < patch.center.z() + kLowestBack_m) continue;
    balance += p.area_m2 * box.axis.dot(flat(p.at) - box.center);
  }
  return balance < 0;
}

}  // namespace

std::vector<Seat> find_seats(const LabelledSurface& surface, const LabelSet& labels, const std::vector<TableTop>& tables) {
  std::vector<Seat> seats;
  for (const auto& [id, points] : surface.of_object) {
    if (!is_seat_class(labels.name_of(surface.class_of.at(id)))) continue;
    const auto patch = level_patch(points, kSeatBand, surface.voxel_m, kSmallestSeat_m2);
    if (!patch) continue;
    const auto from_back = away_from_back(points, *patch);
    const Vec2d facing = from_back ? *from_back : away_from_all(flat(patch->center), tables, surface.wall);
    for (Seat& seat : places_on(*patch, facing)) {
      seat.has_back = from_back.has_value();
      seat.object = id;
      seats.push_back(seat);
    }
  }
  return seats;
}

std::vector<LyingPlace> find_lying_places(const LabelledSurface& surface, const LabelSet& labels) {
  constexpr HeightSpan kBand{0.15, 0.9};
  constexpr double kLength_m = 1.4;  // a child's bed
  constexpr double kWidth_m = 0.5;   // shoulders
  std::vector<LyingPlace> places;
  for (const auto& [id, points] : surface.of_object) {
    if (!is_lying_class(labels.name_of(surface.class_of.at(id)))) continue;
    const auto patch = level_patch(points, kBand, surface.voxel_m, kLength_m * kWidth_m / 2);
    if (!patch) continue;
    std::vector<Vec2d> from_above;
    for (const Vec3d& p : patch->points) from_above.push_back(flat(p));
    const Polygon hull = convex_hull(std::move(from_above));
    const FlatBox box = smallest_box(hull);
    if (box.size_m.x() < kLength_m || box.size_m.y() < kWidth_m) continue;
    const double z = patch->center.z();
    LyingPlace place;
    for (const Vec2d& corner : simplified(hull, surface.voxel_m / 2)) place.polygon.emplace_back(corner.x(), corner.y(), z);
    const Vec2d axis = head_is_behind(points, *patch, box) ? Vec2d(-box.axis) : box.axis;
    place.center = {box.center.x(), box.center.y(), z};
    place.axis = {axis.x(), axis.y(), 0};
    place.length_m = box.size_m.x();
    place.width_m = box.size_m.y();
    place.height_m = z;
    place.object = id;
    places.push_back(std::move(place));
  }
  return places;
}

}  // namespace panoptic
