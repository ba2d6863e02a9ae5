// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Points spread evenly over the surface of a map,.
#pragma once

#include <cstddef>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

struct PlacedNormal {
  Vec3d at = Vec3d::Zero();
  Vec3d normal = Vec3d::UnitZ();  // away from the surface
};

// One point per cube with this edge that holds surface; the same whatever the order of the map's blocks.
std::vector<PlacedNormal> surface_points(const VoxelMap& map, double spacing_m);

// `count` of them at most, spread over the list.
std::vector<PlacedNormal> some_of(const std::vector<PlacedNormal>& points, std::size_t count);

}  // namespace panoptic
