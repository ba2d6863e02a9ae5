// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One surface, and a surface of the map, as far as what moves is told from them.
#pragma once

#include <algorithm>
#include <cmath>

#include "panoptic/fusion/carving.h"
#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/map.h"
#include "panoptic/map/voxel_grid.h"

namespace panoptic {

// A step in depth that two samples of one surface may have.
inline float step_m(float z_m) { return 0.03F + 0.01F * z_m; }

// The frames that a surface must have been seen in. Things without a class were fused for some before they were known to move.
inline float frames_of_surface(ClassId class_id) {
  constexpr float kFramesOfSurface = 10;  // a walker has gone by after as many
  return class_id == ClassId::kUnknown ? kFramesOfSurface : 1;
}

// The map has a surface there, and has had it for so many frames.
inline bool is_surface(const VoxelMap& map, const Vec3d& point_m, float z_m, float frames) {
  const auto place = place_of(point_m, double{map.voxel_size_m()});
  if (!place) return false;
  const VoxelBlock* block = map.find(place->block);
  if (block == nullptr || block->weight(place->offset) * z_m * z_m < frames) return false;
  const float reach = std::max(kSurfaceBand_voxels * map.voxel_size_m(), depth_error_m(z_m));
  return std::abs(block->distance(place->offset)) < reach;
}

}  // namespace panoptic
