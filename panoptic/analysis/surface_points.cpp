// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/surface_points.h"

#include <algorithm>
#include <numeric>
#include <unordered_set>

#include "panoptic/map/surface_sampler.h"

namespace panoptic {
namespace {

// Cubes 2^21 edges apart share a key: 168 km at 8 cm.
std::uint64_t cube_key(const Eigen::Vector3i& cube) {
  constexpr std::uint64_t kMask = (1U << 21) - 1;
  const auto part = [](int c) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(c)) & kMask; };
  return part(cube.x()) | part(cube.y()) << 21 | part(cube.z()) << 42;
}

Eigen::Vector3i cube_of(const Vec3d& at, double edge_m) { return (at / edge_m).array().floor().matrix().cast<int>(); }

std::vector<Slot> by_place(const VoxelMap& map) {
  std::vector<Slot> slots(map.block_count());
  std::iota(slots.begin(), slots.end(), Slot{0});
  std::sort(slots.begin(), slots.end(), [&](Slot a, Slot b) { return map.index_of(a) < map.index_of(b); });
  return slots;
}

}  // namespace

std::vector<PlacedNormal> surface_points(const VoxelMap& map, double spacing_m) {
  std::vector<PlacedNormal> points;
  std::unordered_set<std::uint64_t> taken;
  SurfaceSampler sampler(map);
  for (const Slot slot : by_place(map)) {
    visit_surface(map.block(slot), map.index_of(slot), map.voxel_size_m(), [&](LabelSlot, const VoxelIndex& voxel) {
      const Vec3d center = center_m(voxel, map.voxel_size_m());
      NearSurface near;
      if (taken.contains(cube_key(cube_of(center, spacing_m))) || !sampler.at(center, near)) return;
      const Vec3d normal = near.normal.cast<double>();
      const Vec3d at = center - double{near.distance_m} * normal;
      if (taken.insert(cube_key(cube_of(center, spacing_m))).second) points.push_back({at, normal});
    });
  }
  return points;
}

std::vector<PlacedNormal> some_of(const std::vector<PlacedNormal>& points, std::size_t count) {
  if (points.size() <= count) return points;
  std::vector<PlacedNormal> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(points[i * points.size() / count]);
  return some;
}

}  // namespace panoptic
