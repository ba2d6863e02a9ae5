// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The place and the size of a thing, from its surface voxels.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/map.h"
#include "panoptic/map/voxel_grid.h"

namespace panoptic {

inline constexpr double kLeastArea_m2 = 0.02;  // two hands: masks that miss leave smaller crumbs

// The box around the voxels without the outermost fiftieth at either end of each axis: masks reach over borders now and then.
ExtentBox trimmed_box(std::vector<VoxelIndex> voxels, double voxel_m);

// The voxels of the part that hangs together, brick by brick, and is most of them; none if there is no such part. Masks that miss
// leave crumbs elsewhere.
std::vector<VoxelIndex> main_part(const std::vector<VoxelIndex>& voxels);

// The middle of the voxel lies in the box, made so much wider at each side.
bool is_inside(const ExtentBox& box, const VoxelIndex& at, double voxel_m, double wider_m);

// The surface that so many voxels around it are of.
double area_of(std::uint64_t voxels, double voxel_m);

// Puts down where a thing was that this surface is left of, and whether there is as much of it as of a thing: it hangs together,
// and fills a good part of a side of its box. Where a network saw something on the surface of another thing, which still stands
// there, crumbs were looked through that lie far apart.
bool is_thing(const std::vector<VoxelIndex>& surface, double voxel_m, PastObject& past);

// The smaller of two sizes as a share of the larger one.
double share_of(double a, double b);

// How alike two boxes are, whichever way they stand: the product of the shares of their edges; 0 if they cannot be of one thing.
double likeness(const ExtentBox& a, const ExtentBox& b);

}  // namespace panoptic
