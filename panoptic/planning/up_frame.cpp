// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/up_frame.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr double kBin_m = 0.02;
constexpr double kSmallestFloor_m2 = 0.25;

// Points of the surface that may tell something about the floor.
struct Levels {
  std::vector<Vec3d> labelled;  // level, of a floor class
  std::vector<Vec3d> all;       // level, of any class
};

template <typename Visit>
void visit_points(const SurfaceByBlock& surface, const Visit& visit) {
  for (const auto& block : surface) {
    for (const SurfaceSample& point : block) visit(point);
  }
}

// The sum of the normals of the floor's surface, less that of the ceiling's.
Vec3d up_by_labels(const PanopticMap& map, const SurfaceByBlock& surface) {
  Vec3d sum = Vec3d::Zero();
  visit_points(surface, [&](const SurfaceSample& point) {
    const ClassId id = map.class_of(point.label);
    if (is_floor_class(map.labels, id)) sum += point.normal.cast<double>();
    if (map.labels.name_of(id) == "ceiling") sum -= point.normal.cast<double>();
  });
  return sum;
}

// The direction of most normals around `up`: rooms are full of level surfaces.
Vec3d common_normal(const SurfaceByBlock& surface, const Vec3d& up) {
  constexpr std::array kCosines = {0.7, 0.85, 0.95, 0.985, 0.985};
  Vec3d direction = up;
  for (const double cosine : kCosines) {
    Vec3d sum = Vec3d::Zero();
    visit_points(surface, [&](const SurfaceSample& point) {
      const Vec3d normal = point.normal.cast<double>();
      if (normal.dot(direction) > cosine) sum += normal;
    });
    if (sum.norm() > 0) direction = sum.normalized();
  }
  return direction;
}

Levels levels_of(const PanopticMap& map, const SurfaceByBlock& surface, const Vec3d& up) {
  Levels levels;
  visit_points(surface, [&](const SurfaceSample& point) {
    if (!(point.normal.cast<double>().dot(up) > kLevelCosine)) return;
    levels.all.emplace_back(point.at_m.cast<double>());
    if (is_floor_class(map.labels, map.class_of(point.label))) levels.labelled.push_back(levels.all.back());
  });
  return levels;
}

// The height of the largest level surface; with `lowest`, of the lowest one that is at least a third of that.
double level_height_m(const std::vector<Vec3d>& points, const Vec3d& up, bool lowest) {
  std::map<int, std::size_t> bins;
  for (const Vec3d& p : points) ++bins[static_cast<int>(std::floor(p.dot(up) / kBin_m))];
  std::map<int, std::size_t> near;  // with the bins beside it
  std::size_t most = 0;
  for (const auto& [bin, count] : bins) {
    for (int b = bin - 1; b <= bin + 1; ++b) {
      const auto found = bins.find(b);
      if (found != bins.end()) near[bin] += found->second;
    }
    most = std::max(most, near[bin]);
  }
  const std::size_t enough = lowest ? (most + 2) / 3 : most;
  auto best = std::find_if(near.begin(), near.end(), [&](const auto& n) { return n.second >= enough; });
  for (auto next = std::next(best); next != near.end() && next->first == best->first + 1 && next->second > best->second; ++next) {
    best = next;
  }
  return (best->first + 0.5) * kBin_m;
}

// Points within 5 cm of a height along up.
std::vector<Vec3d> points_near(const std::vector<Vec3d>& points, const Vec3d& up, double height_m) {
  constexpr double kNear_m = 0.05;
  std::vector<Vec3d> near;
  std::copy_if(points.begin(), points.end(), std::back_inserter(near),
               [&](const Vec3d& p) { return std::abs(p.dot(up) - height_m) <= kNear_m; });
  return near;
}

// The normal of the plane through the points, if they are wide enough to tell better than the normals do.
Vec3d plane_normal(const std::vector<Vec3d>& points, const Vec3d& up) {
  constexpr double kWide_m = 0.4;       // standard deviation along the narrower direction
  constexpr double kMostTilt = 0.9986;  // cosine of 3 degrees
  Vec3d mean = Vec3d::Zero();
  for (const Vec3d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vec3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance / static_cast<double>(points.size()));
  if (std::sqrt(std::max(0.0, solver.eigenvalues()[1])) < kWide_m) return up;
  Vec3d normal = solver.eigenvectors().col(0);
  if (normal.dot(up) < 0) normal = -normal;
  return normal.dot(up) > kMostTilt ? normal : up;
}

double mean_height_m(const std::vector<Vec3d>& points, const Vec3d& up) {
  double sum = 0;
  for (const Vec3d& p : points) sum += p.dot(up);
  return sum / static_cast<double>(points.size());
}

Vec3d first_guess(const PanopticMap& map, const SurfaceByBlock& surface, const std::optional<Vec3d>& up) {
  if (up && up->allFinite() && up->norm() > 0) return up->normalized();
  const Vec3d by_labels = up_by_labels(map, surface);
  if (!(by_labels.norm() > 0)) throw Error("nothing tells which way is up: the map has no floor or ceiling label; say it");
  return by_labels.normalized();
}

}  // namespace

UpFrame up_frame(const PanopticMap& map, const SurfaceByBlock& surface, const std::optional<Vec3d>& given_up) {
  if (std::all_of(surface.begin(), surface.end(), [](const auto& block) { return block.empty(); })) {
    throw Error("the map has no surface; map a recording with depth first");
  }
  Vec3d up = common_normal(surface, first_guess(map, surface, given_up));
  const Levels levels = levels_of(map, surface, up);
  const double voxel_m2 = double{map.voxels.voxel_size_m()} * map.voxels.voxel_size_m();
  const auto area_m2 = [&](const std::vector<Vec3d>& points) { return static_cast<double>(points.size()) * voxel_m2; };
  UpFrame frame;
  frame.floor_is_labelled = area_m2(levels.labelled) >= kSmallestFloor_m2;
  const std::vector<Vec3d>& points = frame.floor_is_labelled ? levels.labelled : levels.all;
  if (area_m2(points) < kSmallestFloor_m2) {
    throw Error("the map has no floor: less than a quarter of a square metre of its surface is level");
  }
  double height_m = level_height_m(points, up, !frame.floor_is_labelled);
  std::vector<Vec3d> floor;
  for (int round = 0; round < 3; ++round) {
    floor = points_near(points, up, height_m);
    const Vec3d plane_up = plane_normal(floor, up);
    height_m = mean_height_m(floor, plane_up);
    up = plane_up;
  }
  frame.floor_area_m2 = area_m2(floor);
  frame.grid_from_world.linear() = Eigen::Quaterniond::FromTwoVectors(up, Vec3d::UnitZ()).toRotationMatrix();
  frame.grid_from_world.translation() = Vec3d(0, 0, -height_m);
  return frame;
}

UpFrame up_frame(const PanopticMap& map, const std::optional<Vec3d>& up) {
  return up_frame(map, surface_samples(map.voxels), up);
}

}  // namespace panoptic
