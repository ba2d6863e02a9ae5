// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of the map near a point: how far away it is, and which way it faces.
#pragma once

#include <array>

#include "panoptic/geometry.h"
#include "panoptic/map/cached_lookup.h"
#include "panoptic/map/voxel_grid.h"

namespace panoptic {

struct NearSurface {
  float distance_m = 0;           // signed, positive in front of the surface
  Vec3f normal = Vec3f::UnitZ();  // world, away from the surface
};

// Interpolates between the eight voxels around a point. One per thread; make a new one after the map changed.
class SurfaceSampler {
 public:
  explicit SurfaceSampler(const VoxelMap& map)
      : lookup_(map), per_voxel_(1.0 / double{map.voxel_size_m()}), voxel_m_(map.voxel_size_m()) {}

  // False where one of the eight voxels was never observed, or the distances there do not grow towards a side: far from
  // surfaces, and between two.
  bool at(const Vec3d& point_m, NearSurface& sample);

 private:
  // The distances of the voxel `first` and of its neighbours: bit a of a number is the step along axis a. False if one was never
  // observed.
  bool corners(const VoxelIndex& first, std::array<float, 8>& distance);
  bool corners_in_brick(const VoxelIndex& first, unsigned split, unsigned far, std::array<float, 8>& distance);

  CachedLookup lookup_;
  double per_voxel_;
  float voxel_m_;
};

}  // namespace panoptic
