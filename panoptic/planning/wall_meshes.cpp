// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/wall_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

namespace panoptic {
namespace {

constexpr double kSmallest_m2 = 0.5;
constexpr double kNear_m = 0.05;   // from the plane
constexpr double kUpright = 0.35;  // the most that the normal of upright surface may have along z
constexpr float kAligned = 0.9F;   // cosine between normals of the wall and of its samples
constexpr std::size_t kMostWalls = 200;
constexpr int kDirections = 72;     // bins of 5 degrees
constexpr double kOffset_m = 0.05;  // bins of the distance from the origin

// A sample of upright surface in the z-up frame.
struct UprightSample {
  Vec3f at_m;
  Vec3f normal;
  bool is_left = true;  // no wall has it yet
};
using Members = std::vector<std::uint32_t>;

struct WallPlane {
  Vec3d normal = Vec3d::UnitX();
  double offset_m = 0;
};

using Bin = std::pair<int, int>;  // direction, offset

Bin bin_of(const UprightSample& sample) {
  const double angle = std::atan2(double{sample.normal.y()}, double{sample.normal.x()}) + std::numbers::pi;
  const int direction = static_cast<int>(std::lround(angle / (2 * std::numbers::pi) * kDirections)) % kDirections;
  // The offset along the middle of the bin, so that samples of one wall agree on it.
  const double middle = direction * 2 * std::numbers::pi / kDirections - std::numbers::pi;
  const double offset = sample.at_m.x() * std::cos(middle) + sample.at_m.y() * std::sin(middle);
  return {direction, static_cast<int>(std::floor(offset / kOffset_m))};
}

// Samples by bin, the bins with most samples first.
std::vector<Members> bins_of(const std::vector<UprightSample>& samples) {
  std::map<Bin, Members> by_bin;
  for (std::uint32_t i = 0; i < samples.size(); ++i) by_bin[bin_of(samples[i])].push_back(i);
  std::vector<Members> bins;
  for (auto& [bin, members] : by_bin) bins.push_back(std::move(members));
  std::stable_sort(bins.begin(), bins.end(), [](const Members& a, const Members& b) { return a.size() > b.size(); });
  return bins;
}

// The upright plane through samples, from their means. REQUIRES some.
WallPlane plane_of(const std::vector<UprightSample>& samples, const Members& members) {
  Vec3d normal = Vec3d::Zero();
  Vec3d middle = Vec3d::Zero();
  for (const std::uint32_t i : members) {
    normal += Vec3d(samples[i].normal.x(), samples[i].normal.y(), 0);
    middle += samples[i].at_m.cast<double>();
  }
  normal.normalize();
  return {normal, normal.dot(middle / static_cast<double>(members.size()))};
}

bool is_on(const UprightSample& sample, const WallPlane& plane) {
  return sample.normal.dot(plane.normal.cast<float>()) > kAligned &&
         std::abs(sample.at_m.cast<double>().dot(plane.normal) - plane.offset_m) < kNear_m;
}

// Samples near a plane that no wall has yet.
Members left_on(const std::vector<UprightSample>& samples, const WallPlane& plane) {
  Members members;
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    if (samples[i].is_left && is_on(samples[i], plane)) members.push_back(i);
  }
  return members;
}

std::vector<UprightSample> upright_samples(const PanopticMap& map, const UpFrame& frame, const SurfaceByBlock& surface) {
  const Eigen::Isometry3f grid_from_world = frame.grid_from_world.cast<float>();
  const LabelClass* wall = map.labels.find("wall");
  std::vector<UprightSample> labelled;
  std::vector<UprightSample> all;
  for (const auto& block : surface) {
    for (const SurfaceSample& sample : block) {
      const Vec3f normal = grid_from_world.linear() * sample.normal;
      if (normal.head<2>().norm() < 1 - kUpright || std::abs(normal.z()) > kUpright) continue;
      all.push_back({grid_from_world * sample.at_m, normal});
      if (wall != nullptr && map.class_of(sample.label) == wall->id) labelled.push_back(all.back());
    }
  }
  return labelled.empty() ? all : labelled;
}

Pose wall_from_grid(const WallPlane& plane) {
  Pose pose = Pose::Identity();
  const Vec3d along = Vec3d::UnitZ().cross(plane.normal).normalized();
  pose.linear().row(0) = along.transpose();
  pose.linear().row(1) = Vec3d::UnitZ().transpose();
  pose.linear().row(2) = plane.normal.transpose();
  pose.translation() = Vec3d(0, 0, -plane.offset_m);
  return pose;
}

// All surface near the wall's own, in the wall's frame; its own is the floor.
std::vector<GroundSample> samples_on(const Pose& wall_from_world, const SurfaceByBlock& surface,
                                     const Eigen::AlignedBox2f& extent, const std::vector<bool>& wall_label) {
  constexpr float kBehind_m = 0.1F;
  constexpr float kBefore_m = 0.3F;
  const Eigen::Isometry3f to_wall = wall_from_world.cast<float>();
  std::vector<GroundSample> samples;
  for (const auto& block : surface) {
    for (const SurfaceSample& sample : block) {
      const Vec3f at = to_wall * sample.at_m;
      if (at.z() < -kBehind_m || at.z() > kBefore_m || !extent.contains(at.head<2>())) continue;
      const bool faces_out = (to_wall.linear() * sample.normal).z() > kAligned;
      const bool is_wall = faces_out && std::abs(at.z()) < static_cast<float>(kNear_m) && wall_label[number(sample.label)];
      samples.push_back({at, is_wall, false, sample.label});
    }
  }
  return samples;
}

std::vector<bool> wall_labels(const PanopticMap& map) {
  const LabelClass* wall = map.labels.find("wall");
  std::vector<bool> is_wall(kLabelSlots, false);
  bool any = false;
  for (std::size_t n = 0; n < kLabelSlots && wall != nullptr; ++n) {
    is_wall[n] = map.class_of(static_cast<LabelSlot>(n)) == wall->id;
    any = any || is_wall[n];
  }
  if (!any) is_wall.assign(kLabelSlots, true);
  return is_wall;
}

// Takes the samples of the wall that those of a bin belong to; none if too few of the bin are left.
Members take_wall(std::vector<UprightSample>& samples, Members bin, std::size_t fewest, WallPlane& plane) {
  std::erase_if(bin, [&](std::uint32_t i) { return !samples[i].is_left; });
  if (bin.size() < std::max<std::size_t>(fewest / 4, 1)) return {};
  const Members near = left_on(samples, plane_of(samples, bin));
  if (near.empty()) return {};
  plane = plane_of(samples, near);
  Members members = left_on(samples, plane);
  for (const std::uint32_t i : members) samples[i].is_left = false;
  return members;
}

}  // namespace

std::vector<WallMesh> wall_meshes(const PanopticMap& map, const UpFrame& frame, const SurfaceByBlock& surface) {
  const double voxel_m = map.voxels.voxel_size_m();
  const auto fewest = static_cast<std::size_t>(kSmallest_m2 / (voxel_m * voxel_m));
  const std::vector<bool> is_wall = wall_labels(map);
  std::vector<UprightSample> samples = upright_samples(map, frame, surface);
  std::vector<WallMesh> walls;
  for (Members& bin : bins_of(samples)) {
    if (bin.size() < fewest / 4 || walls.size() == kMostWalls) break;
    WallPlane plane;
    const Members members = take_wall(samples, std::move(bin), fewest, plane);
    if (members.size() < fewest) continue;
    const Pose to_wall = wall_from_grid(plane);
    Eigen::AlignedBox2f extent;
    for (const std::uint32_t i : members) extent.extend((to_wall * samples[i].at_m.cast<double>()).head<2>().cast<float>());
    SolidColumns columns =
        solid_columns(samples_on(to_wall * frame.grid_from_world, surface, extent, is_wall), voxel_m, voxel_m, kInsect.climb_m);
    mark_walkable(columns, kInsect);
    walls.push_back({to_wall, static_cast<double>(members.size()) * voxel_m * voxel_m, RecastMesh(columns, kInsect)});
  }
  std::stable_sort(walls.begin(), walls.end(), [](const WallMesh& a, const WallMesh& b) { return a.area_m2 > b.area_m2; });
  return walls;
}

}  // namespace panoptic
