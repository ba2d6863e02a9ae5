// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/viewpoints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace panoptic {
namespace {

using Eigen::Matrix3d;
using std::numbers::pi;

constexpr int kWidth_px = 1280;
constexpr int kHeight_px = 960;
constexpr int kMargin_px = 28;
constexpr double kFieldOfView = 42 * pi / 180;      // across
constexpr double kPlanFieldOfView = 24 * pi / 180;  // from far above, so that walls take little of the picture
constexpr double kElevation = 40 * pi / 180;
constexpr std::size_t kMaxSamples = 40000;
constexpr double kStray = 0.006;  // this share of a mesh may be odd bits far away from the rest

struct Patch {
  Vec3d at = Vec3d::Zero();
  Vec3d normal_times_area = Vec3d::Zero();
};

std::vector<Patch> patches_of(const Mesh& mesh) {
  std::vector<Patch> patches;
  const std::size_t step = mesh.triangles.size() / kMaxSamples + 1;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += step) {
    const auto corner = [&](std::size_t k) -> Vec3d { return mesh.vertices[mesh.triangles[i][k]].position.cast<double>(); };
    const Patch patch = {(corner(0) + corner(1) + corner(2)) / 3, 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0))};
    if (patch.at.allFinite() && patch.normal_times_area.allFinite()) patches.push_back(patch);
  }
  return patches;
}

// Two horizontal directions and up, right-handed: (forward, left, up).
Matrix3d level_axes(const Vec3d& up) {
  const Vec3d any = std::abs(up.z()) < 0.9 ? Vec3d::UnitZ() : Vec3d::UnitX();
  const Vec3d forward = (any - any.dot(up) * up).normalized();
  return (Matrix3d() << forward, up.cross(forward), up).finished();
}

// A camera that looks along `forward`, its -y towards `up`.
Matrix3d world_from_camera_rotation(const Vec3d& forward, const Vec3d& up) {
  const Vec3d right = forward.cross(up).normalized();
  return (Matrix3d() << right, forward.cross(right), forward).finished();
}

double share_of(std::vector<double>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// The highest value, but not one far above the rest.
double bulk_max(std::vector<double> values) {
  const double middle = share_of(values, 0.5);
  const double high = share_of(values, 1 - kStray);
  return std::min(*std::max_element(values.begin(), values.end()), high + 0.1 * (high - middle));
}

// Along one image axis the camera at (c, cz) sees all points with |x - c| <= tan * (z - cz). Returns (c, the nearest cz).
std::pair<double, double> stand_for(const std::vector<Vec3d>& points, int axis, double tangent) {
  std::vector<double> low;
  std::vector<double> high;
  for (const Vec3d& point : points) {
    low.push_back(-point[axis] - tangent * point.z());
    high.push_back(point[axis] - tangent * point.z());
  }
  const double a = bulk_max(std::move(high));
  const double b = bulk_max(std::move(low));
  return {(a - b) / 2, -(a + b) / (2 * tangent)};
}

// A view in that direction, from as near as shows everything.
View fitted(const std::vector<Patch>& patches, const Matrix3d& rotation, double field_of_view) {
  const double focal = kWidth_px / 2.0 / std::tan(field_of_view / 2);
  const double free_height = kHeight_px - kLegendRows_px;
  View view;
  view.camera = {kWidth_px, kHeight_px, focal, focal, (kWidth_px - 1) / 2.0, (free_height - 1) / 2.0};
  view.world_from_camera.linear() = rotation;
  std::vector<Vec3d> points;
  for (const Patch& patch : patches) points.emplace_back(rotation.transpose() * patch.at);
  if (points.empty()) return view;
  const auto [x, z_across] = stand_for(points, 0, (kWidth_px / 2.0 - kMargin_px) / focal);
  const auto [y, z_down] = stand_for(points, 1, (free_height / 2.0 - kMargin_px) / focal);
  view.world_from_camera.translation() = rotation * Vec3d(x, y, std::min(z_across, z_down));
  return view;
}

Vec3d towards_camera(const Matrix3d& level, double azimuth) {
  return level * Vec3d(std::cos(kElevation) * std::cos(azimuth), std::cos(kElevation) * std::sin(azimuth), std::sin(kElevation));
}

double square(double x) { return x * x; }

double distance(double a, double b) { return std::abs(std::remainder(a - b, 2 * pi)); }

// How much surface faces a camera in that direction, in square metres.
double facing_m2(const std::vector<Patch>& patches, const Vec3d& direction) {
  double sum = 0;
  for (const Patch& patch : patches) sum += std::max(0.0, patch.normal_times_area.dot(direction));
  return sum;
}

// The azimuth with the most of `worth`, of 48.
template <typename Worth>
double best_azimuth(const Worth& worth) {
  constexpr int kAzimuths = 48;
  std::array<double, kAzimuths> values{};
  for (int i = 0; i < kAzimuths; ++i) values[static_cast<std::size_t>(i)] = worth(2 * pi * i / kAzimuths);
  return 2 * pi * static_cast<double>(std::max_element(values.begin(), values.end()) - values.begin()) / kAzimuths;
}

// The direction of the walls, modulo 90 degrees: by their normals.
double wall_azimuth(const std::vector<Patch>& patches, const Matrix3d& level) {
  double sine = 0;
  double cosine = 0;
  for (const Patch& patch : patches) {
    const Vec3d normal = level.transpose() * patch.normal_times_area;
    const double azimuth = std::atan2(normal.y(), normal.x());
    const double weight = normal.head<2>().norm();
    sine += weight * std::sin(4 * azimuth);
    cosine += weight * std::cos(4 * azimuth);
  }
  return std::atan2(sine, cosine) / 4;
}

// Chooses among the four ways to turn a plan parallel to the walls: the two with the longer side across, and of these the one
// nearer to how the view from `front` shows the room.
Vec3d up_on_plan(const std::vector<Patch>& patches, const Matrix3d& level, double front) {
  const double wall = wall_azimuth(patches, level);
  double best = wall;
  double best_score = -1;
  for (int i = 0; i < 4; ++i) {
    const double azimuth = wall + i * pi / 2;
    const Vec3d along = level * Vec3d(std::cos(azimuth), std::sin(azimuth), 0);
    std::vector<double> values;
    for (const Patch& patch : patches) values.push_back(along.dot(patch.at));
    const double extent = values.empty() ? 0 : share_of(values, 1 - kStray) - share_of(values, kStray);
    const double score = 1 / (1e-9 + extent) * (1 + 1e-3 * distance(azimuth, front));
    if (score <= best_score) continue;
    best_score = score;
    best = azimuth;
  }
  return level * Vec3d(std::cos(best), std::sin(best), 0);
}

}  // namespace

std::vector<View> default_views(const Mesh& mesh, const Vec3d& up) {
  const Vec3d unit_up = up.allFinite() && up.norm() > 1e-9 ? up.normalized() : Vec3d(-Vec3d::UnitY());
  const Matrix3d level = level_axes(unit_up);
  const std::vector<Patch> patches = patches_of(mesh);
  const auto facing = [&](double azimuth) { return facing_m2(patches, towards_camera(level, azimuth)); };
  const double front = best_azimuth(facing);
  // The other side of a room; of a scan from one side, rather less far round than nothing but the backs of things.
  const double side =
      best_azimuth([&](double azimuth) { return square(facing(azimuth)) * std::sin(distance(azimuth, front) / 2); });
  const auto oblique = [&](double azimuth) {
    return fitted(patches, world_from_camera_rotation(-towards_camera(level, azimuth), unit_up), kFieldOfView);
  };
  const Matrix3d down = world_from_camera_rotation(-unit_up, up_on_plan(patches, level, front));
  std::vector<View> views = {oblique(front), oblique(side), fitted(patches, down, kPlanFieldOfView)};
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].name = kViewNames[i];
    views[i].up = unit_up;
  }
  return views;
}

}  // namespace panoptic
