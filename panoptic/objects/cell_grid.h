// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Surface voxels on a coarser grid, for what lies too far apart to be looked for voxel by voxel.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "panoptic/objects/surface_voxels.h"

namespace panoptic {

// A cell is a cube of `voxels_per_cell` voxels an edge; a voxel lies in the cell floor(at / voxels_per_cell). Cells are kept like
// voxels, in blocks of 16 an edge, and i is always the index of a surface voxel.
class CellGrid {
 public:
  CellGrid(const SurfaceVoxels& surface, int voxels_per_cell);

  std::size_t block_count() const { return neighbours_.size(); }
  // The block and place in it of the cell that the voxel lies in.
  std::pair<Slot, std::uint16_t> place_of(std::uint32_t i) const { return places_[i]; }

  // Visits the rows of cells around the voxel's cell, as SurfaceVoxels::visit_rows visits rows of voxels.
  template <typename HalfWidth, typename Visit>
  void visit_rows(std::uint32_t i, int reach, HalfWidth&& half_width, Visit&& visit) const {
    const auto [slot, place] = places_[i];
    visit_rows_around(neighbours_[slot], place, reach, half_width, visit);
  }

 private:
  std::vector<std::pair<Slot, std::uint16_t>> places_;  // by surface voxel
  std::vector<NeighbourSlots> neighbours_;              // by block of cells
};

}  // namespace panoptic
