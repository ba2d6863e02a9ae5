// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Which way is up, where the tops of tables are, and what stands on them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "panoptic/base/geometry.h"
#include "panoptic/fusion/surface_voxels.h"

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

// The top of a table from its points; nothing if they hold no horizontal plane.
std::optional<SupportTop> fit_top(const VoxelMap& map, const SurfaceVoxels& surface, std::span<const std::uint32_t> points,
                                  const Vec3d& up);

// The points that stand out of a top by this and by less than the height of things on tables. Where `within_footprint` says so,
// only over what was seen of it.
bool stands_on(const SupportTop& top, const Vec3d& p, double height_m, bool within_footprint);

// Is there a place in the block with this lowest voxel (as SurfaceVoxel::at) that may be over the footprint of a top, and one
// that may stand out of it by this? Never wrongly no.
bool may_be_over(const SupportTop& top, const std::array<std::int32_t, 3>& corner, double voxel_m);
bool may_stand_on(const SupportTop& top, const std::array<std::int32_t, 3>& corner, double voxel_m, double height_m);

// Outward, from the distances of the neighbours within the block; zero where they were not observed.
Vec3d normal_of(const VoxelMap& map, const SurfaceVoxel& p);
Vec3d place_m(const SurfaceVoxel& p, double voxel_m);

}  // namespace panoptic
