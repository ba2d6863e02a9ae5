// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of a map as points: where the signed distance changes its sign between two neighbouring voxels. These are the
// vertices that marching cubes would make, without the triangles.
#pragma once

#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

struct SurfaceSample {
  Vec3f at_m = Vec3f::Zero();
  Vec3f normal = Vec3f::Zero();  // unit length, towards free space
  LabelSlot label = LabelSlot::kUnknown;
  float weight = 0;  // how well it was seen: the smaller weight of the two voxels
};

using SurfaceByBlock = std::vector<std::vector<SurfaceSample>>;  // by slot

// The points between the voxels of this block and their next ones along x, y and z, which may lie in the next blocks.
std::vector<SurfaceSample> surface_samples(const VoxelMap& map, Slot slot);
SurfaceByBlock surface_samples(const VoxelMap& map);
// Their places alone, in the same order; quicker.
std::vector<Vec3f> surface_places(const VoxelMap& map, Slot slot);

// A class whose surface people walk on.
bool is_floor_class(const LabelSet& labels, ClassId id);

}  // namespace panoptic
