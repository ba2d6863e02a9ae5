// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Cuts a set of blocks into tiles that hang together, by growing regions block by block (section III-G of the paper), so that
// each holds few labels.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "panoptic/voxel_map.h"

namespace panoptic {

// Every slot of `slots` (none twice) is in exactly one tile of at most `most_blocks` blocks; 0 = no limit, and one tile even
// if the blocks do not touch. Within a tile slots are in the order of their blocks' keys. Depends on where the blocks lie, not
// on their slots.
std::vector<std::vector<Slot>> divide_into_tiles(const VoxelMap& map, std::span<const Slot> slots, std::size_t most_blocks);

}  // namespace panoptic
