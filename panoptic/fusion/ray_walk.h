// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The voxels along a segment, in order (Amanatides and Woo 1987).
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "panoptic/geometry.h"

#include "panoptic/base/floor.h"

namespace panoptic {

// Calls visit(x, y, z) for every cell of the unit grid that the segment from `start` to `end` passes through, start cell first.
// Exact in the sense that the same two points always give the same cells. REQUIRES coordinates within the range of int32.
template <typename Visit>
void walk_cells(const Vec3f& start, const Vec3f& end, Visit&& visit) {
  std::int32_t cell[3];
  std::int32_t step[3];
  float next[3];   // path parameter (0..1) at which the next cell border on this axis is crossed
  float delta[3];  // path parameter per cell
  int steps = 0;
  for (int a = 0; a < 3; ++a) {
    const float length = end[a] - start[a];
    cell[a] = floor_to_int(start[a]);
    steps += std::abs(floor_to_int(end[a]) - cell[a]);
    step[a] = length > 0 ? 1 : -1;
    const float border = static_cast<float>(cell[a]) + (length > 0 ? 1.0F : 0.0F);
    next[a] = length != 0 ? (border - start[a]) / length : std::numeric_limits<float>::max();
    delta[a] = length != 0 ? 1.0F / std::abs(length) : std::numeric_limits<float>::max();
  }
  visit(cell[0], cell[1], cell[2]);
  for (int i = 0; i < steps; ++i) {
    const int axis = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    cell[axis] += step[axis];
    next[axis] += delta[axis];
    visit(cell[0], cell[1], cell[2]);
  }
}

// Sixteen walks side by side: the same cells as walk_cells gives, in the same order.
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
