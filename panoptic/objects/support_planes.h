// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds which way is up, where the tops of tables are, and what stands on them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/objects/surface_voxels.h"

namespace panoptic {

// The direction of most surface normals around `up` (unit vectors in the world): rooms are full of horizontal surfaces.
Vec3d vertical(const VoxelMap& map, const SurfaceVoxels& surface, const Vec3d& up);

// A horizontal plane and where it was seen. Heights in metres along up.
struct SupportTop {
  Vec3d up;
  Vec3d east;
  Vec3d north;
  double height_m = 0;  // at the origin of east and north
  double slope_east = 0;
  double slope_north = 0;
  std::unordered_set<std::uint64_t> cells;  // of the footprint
  Eigen::AlignedBox2d bounds_m;             // around it, along east and north

  double height_above(const Vec3d& p) const;
  bool below(const Vec3d& p) const;  // is the top under this place?
};

inline constexpr std::size_t kFewestOfTop = 150;  // level voxels that make a top
inline constexpr double kHighest_m = 0.6;         // of what stands on it

// The top of a table from its points; nothing if they hold no horizontal plane.
std::optional<SupportTop> fit_top(const VoxelMap& map, const SurfaceVoxels& surface, std::span<const std::uint32_t> points,
                                  const Vec3d& up);

// True if the point stands out of a top by more than `height_m` and less than the height of things on tables; if
// `within_footprint`, only over the part of the top that was seen.
bool stands_on(const SupportTop& top, const Vec3d& p, double height_m, bool within_footprint);

// True if the block with this lowest voxel (as SurfaceVoxel::at) may hold a place over the footprint of a top, and one that may
// stand out of it by this. Never wrongly false.
bool may_be_over(const SupportTop& top, const std::array<std::int32_t, 3>& corner, double voxel_m);
bool may_stand_on(const SupportTop& top, const std::array<std::int32_t, 3>& corner, double voxel_m, double height_m);

// The outward normal, from the distances of the neighbours within the block; zero where they were not observed.
Vec3d normal_of(const VoxelMap& map, const SurfaceVoxel& p);
Vec3d place_m(const SurfaceVoxel& p, double voxel_m);

}  // namespace panoptic
