// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The voxels along segments, in order (Amanatides and Woo 1987).
#pragma once

#include <cstddef>
#include <cstdint>

namespace panoptic {

// Sixteen walks side by side, each through every cell of the unit grid that its segment passes through, start cell first. Exact
// in the sense that the same two points always give the same cells.
constexpr std::size_t kWalkLanes = 16;
constexpr std::size_t kMostCells = 128;  // of one walk: enough for segments of 64 cells' length

struct CellWalks {
  alignas(64) float start[3][kWalkLanes];
  alignas(64) float end[3][kWalkLanes];
  alignas(64) std::int32_t count[kWalkLanes];  // of cells
  // The cells of each lane, one after the other; those beyond its count are meaningless.
  alignas(64) std::int32_t cell[3][kMostCells][kWalkLanes];
  alignas(64) std::uint16_t offset[kMostCells][kWalkLanes];  // of the cell in its block, as voxel_offset gives it
  // Bit n of word w: cell 32 w + n lies in another block than the cell before it.
  alignas(64) std::uint32_t borders[kMostCells / 32][kWalkLanes];
};

// Walks from `start` to `end` of all lanes. REQUIRES segments no longer than 64 cells.
void walk_together(CellWalks& walks);

}  // namespace panoptic
