// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How far the surfaces of two maps lie apart.
#pragma once

#include "panoptic/map_pairs.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// REQUIRES maps in one world. The same for any order of their blocks, and at any number of threads.
SurfaceShift shift_between(const VoxelMap& a, const VoxelMap& b);

}  // namespace panoptic
