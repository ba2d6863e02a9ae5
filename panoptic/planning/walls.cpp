// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/walls.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

namespace panoptic {
namespace {

constexpr double kUprightNormal = 0.35;  // sine of 20 degrees off the horizontal
constexpr double kLeastDirection_m2 = 0.5;
constexpr double kLeastPlane_m2 = 0.15;
constexpr double kBeside_m = 0.04;  // of the plane: noise of depth and of voxels
constexpr double kAlong_m = 0.05;   // bins along a plane

Vec2d direction_at(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return {std::cos(angle), std::sin(angle)};
}

struct FacePoints {
  std::vector<LabelledPoint> points;
  double area_m2 = 0;
};

FacePoints upright_points(const LabelledSurface& surface) {
  FacePoints all;
  for (const LabelledPoint& p : surface.wall) {
    if (std::abs(p.normal.z()) > kUprightNormal || p.at.z() < kWallLow_m / 2) continue;
    all.points.push_back(p);
    all.area_m2 += p.area_m2;
  }
  return all;
}

// Takes the points whose normals are within 12 degrees of the most common direction; nothing if too few are left.
std::optional<Vec2d> take_direction(FacePoints& rest, std::vector<LabelledPoint>& taken) {
  constexpr int kBins = 360;
  constexpr int kSmooth = 4;
  const double kNear = std::cos(12 * std::numbers::pi / 180);
  std::array<double, kBins> area{};
  for (const LabelledPoint& p : rest.points) {
    const double degrees = std::atan2(p.normal.y(), p.normal.x()) * 180 / std::numbers::pi;
    area[static_cast<std::size_t>((static_cast<int>(std::floor(degrees)) + kBins) % kBins)] += p.area_m2;
  }
  int best = 0;
  double most_m2 = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    double sum = 0;
    for (int d = -kSmooth; d <= kSmooth; ++d) sum += area[static_cast<std::size_t>((bin + d + kBins) % kBins)];
    if (sum > most_m2) most_m2 = sum, best = bin;
  }
  if (most_m2 < kLeastDirection_m2) return std::nullopt;
  const Vec2d guess = direction_at(best + 0.5);
  Vec2d mean = Vec2d::Zero();
  std::vector<LabelledPoint> left;
  for (const LabelledPoint& p : rest.points) {
    const Vec2d normal = p.normal.head<2>().normalized();
    if (normal.dot(guess) < kNear) {
      left.push_back(p);
      continue;
    }
    taken.push_back(p);
    mean += p.area_m2 * normal;
  }
  rest.points = std::move(left);
  return mean.normalized();
}

// The most common offset along the normal among points, and its area.
std::pair<double, double> common_offset(const std::vector<LabelledPoint>& points, const Vec2d& normal) {
  constexpr double kBin_m = 0.01;
  std::map<int, double> area_at;
  for (const LabelledPoint& p : points) area_at[static_cast<int>(std::floor(normal.dot(p.at.head<2>()) / kBin_m))] += p.area_m2;
  std::pair<double, double> best{0, 0};
  for (const auto& [bin, own] : area_at) {
    double sum = 0;
    for (auto at = area_at.lower_bound(bin - 2); at != area_at.end() && at->first <= bin + 2; ++at) sum += at->second;
    if (sum > best.second) best = {(bin + 0.5) * kBin_m, sum};
  }
  return best;
}

// Turns the plane to fit its points, where they reach far enough to tell better than their normals do.
void refine(WallPlane& plane) {
  constexpr double kFar_m = 0.3;  // standard deviation along the plane
  Vec2d mean = Vec2d::Zero();
  double area_m2 = 0;
  for (const LabelledPoint& p : plane.points) mean += p.area_m2 * p.at.head<2>(), area_m2 += p.area_m2;
  mean /= area_m2;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const LabelledPoint& p : plane.points) {
    const Vec2d from_mean = p.at.head<2>() - mean;
    covariance += p.area_m2 / area_m2 * from_mean * from_mean.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  if (std::sqrt(solver.eigenvalues()[1]) > kFar_m) {
    const Vec2d across = solver.eigenvectors().col(0);
    plane.normal = across.dot(plane.normal) >= 0 ? across : Vec2d(-across);
  }
  plane.offset_m = plane.normal.dot(mean);
}

// Bins with 15 cm of wall above each other are solid.
std::vector<Stretch> solid_stretches(const WallPlane& plane) {
  constexpr double kLeastHeight_m = 0.15;
  struct Bin {
    double area_m2 = 0;
    double low_m = 1e9;
    double high_m = -1e9;
  };
  std::map<int, Bin> bins;
  for (const LabelledPoint& p : plane.points) {
    if (p.at.z() < kWallLow_m || p.at.z() > kWallHigh_m) continue;
    const double along_m = plane.along_m(p.at.head<2>());
    Bin& bin = bins[static_cast<int>(std::floor(along_m / kAlong_m))];
    bin.area_m2 += p.area_m2;
    bin.low_m = std::min(bin.low_m, along_m);
    bin.high_m = std::max(bin.high_m, along_m);
  }
  std::vector<Stretch> stretches;
  int last = 0;
  for (const auto& [number, bin] : bins) {
    if (bin.area_m2 < kAlong_m * kLeastHeight_m) continue;
    if (!stretches.empty() && number == last + 1) {
      stretches.back().high_m = bin.high_m;
    } else {
      stretches.push_back({bin.low_m, bin.high_m});
    }
    last = number;
  }
  return stretches;
}

void take_planes(std::vector<LabelledPoint> points, const Vec2d& normal, std::vector<WallPlane>& planes) {
  while (true) {
    const auto [offset_m, area_m2] = common_offset(points, normal);
    if (area_m2 < kLeastPlane_m2) return;
    WallPlane plane{normal, offset_m, {}, {}};
    std::vector<LabelledPoint> left;
    for (const LabelledPoint& p : points) {
      const double beside_m = std::abs(normal.dot(p.at.head<2>()) - offset_m);
      if (beside_m <= kBeside_m) plane.points.push_back(p);
      if (beside_m > 1.5 * kBeside_m) left.push_back(p);
    }
    points = std::move(left);
    refine(plane);
    plane.solid = solid_stretches(plane);
    if (!plane.solid.empty()) planes.push_back(std::move(plane));
  }
}

// How much of the way from one stretch to the next, just behind the face, is open.
double open_between_m(const WallPlane& plane, const Stretch& gap, const OpenFloor& floor) {
  constexpr double kBehind_m = 0.06;
  double open_m = 0;
  for (double along_m = gap.low_m + kAlong_m / 2; along_m < gap.high_m; along_m += kAlong_m) {
    if (floor.is_open(plane.at(along_m, -kBehind_m))) open_m += kAlong_m;
  }
  return open_m;
}

std::vector<Stretch> joined(const WallPlane& plane, const OpenFloor& floor) {
  constexpr double kPassable_m = 0.3;
  std::vector<Stretch> result;
  for (const Stretch& stretch : plane.solid) {
    const bool joins = !result.empty() && open_between_m(plane, {result.back().high_m, stretch.low_m}, floor) < kPassable_m;
    if (joins) {
      result.back().high_m = stretch.high_m;
    } else {
      result.push_back(stretch);
    }
  }
  return result;
}

struct FaceLine {
  const WallPlane* plane = nullptr;
  Stretch stretch;
};

// Where the end of a line meets the face of another wall: up to 2.5 m farther where something hides the corner, or 0.15 m back
// where voxels round it. `outward`: +1 at the high end, -1 at the low one.
double met_end(const FaceLine& line, int outward, const std::vector<FaceLine>& all, const OpenFloor& floor) {
  constexpr double kHidden_m = 2.5;  // behind a wardrobe
  constexpr double kRounded_m = 0.15;
  constexpr double kBeyondEnd_m = 1.0;
  const double end_m = outward > 0 ? line.stretch.high_m : line.stretch.low_m;
  double best_m = end_m;
  double nearest_m = kHidden_m;
  for (const FaceLine& other : all) {
    const double sine = cross(line.plane->normal, other.plane->normal);
    if (std::abs(sine) < 0.5) continue;
    // The point on both lines, as distances along each.
    const Vec2d corner =
        (line.plane->offset_m * -quarter_turn(other.plane->normal) + other.plane->offset_m * quarter_turn(line.plane->normal)) /
        sine;
    const double farther_m = outward * (line.plane->along_m(corner) - end_m);
    const double on_other_m = other.plane->along_m(corner);
    const bool reaches = on_other_m > other.stretch.low_m - kBeyondEnd_m && on_other_m < other.stretch.high_m + kBeyondEnd_m;
    if (!reaches || farther_m < -kRounded_m || std::abs(farther_m) >= nearest_m) continue;
    const Stretch way = outward > 0 ? Stretch{end_m, end_m + farther_m} : Stretch{end_m - farther_m, end_m};
    if (farther_m > kRounded_m && open_between_m(*line.plane, way, floor) > kRounded_m) continue;
    nearest_m = std::abs(farther_m);
    best_m = line.plane->along_m(corner);
  }
  return best_m;
}

}  // namespace

std::vector<WallPlane> find_wall_planes(const LabelledSurface& surface) {
  FacePoints rest = upright_points(surface);
  std::vector<WallPlane> planes;
  std::vector<LabelledPoint> taken;
  while (const auto normal = take_direction(rest, taken)) {
    take_planes(std::move(taken), *normal, planes);
    taken.clear();
  }
  return planes;
}

std::vector<WallLine> wall_lines(const std::vector<WallPlane>& planes, const OpenFloor& floor) {
  std::vector<FaceLine> faces;
  for (const WallPlane& plane : planes) {
    for (const Stretch& stretch : joined(plane, floor)) faces.push_back({&plane, stretch});
  }
  std::vector<WallLine> lines;
  for (const FaceLine& face : faces) {
    const double low_m = met_end(face, -1, faces, floor);
    const double high_m = met_end(face, 1, faces, floor);
    if (high_m > low_m) lines.push_back({face.plane->at(low_m), face.plane->at(high_m), face.plane->normal});
  }
  return lines;
}

}  // namespace panoptic
