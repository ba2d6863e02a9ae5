// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Answers what is at a point: voxels tell of what is near a surface, cells of free space tell of the rest.
#pragma once

#include <string>

#include "panoptic/free_space.h"
#include "panoptic/geometry.h"
#include "panoptic/map.h"

namespace panoptic {

// A point in the world: free or occupied by the sign of the voxel's distance where it was observed, else as its cell was seen.
// Points that are not finite are unknown.
Space space_at(const PanopticMap& map, const Vec3d& point_m);

// A line for users about a map without free space; empty if it has some.
std::string note_of_space(const PanopticMap& map);

}  // namespace panoptic
