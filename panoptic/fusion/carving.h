// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Carving: clears voxels that say there is a surface where cameras see none. A voxel says there is one at the distance that it
// holds, to either side. A view looks through it if no reading around it, as near as that distance and a voxel more, two voxels
// at least, is from there or from before it; a pixel without reading says nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/fusion/frame_view.h"
#include "panoptic/fusion/sight_tiles.h"
#include "panoptic/map.h"

namespace panoptic {

// No voxel this near to a reading is seen as empty in the same frame.
inline constexpr float kClearance_voxels = 2;

// A cell that so many views saw to be empty, more than to have something in it, is free for certain.
inline constexpr int kSureViews = 5;

// Three standard deviations of the readings of a consumer depth camera: 4 mm at 1 m, 11 cm at 5 m.
inline float depth_error_m(float z_m) { return 0.0045F * z_m * z_m; }

// Voxels of a brick, a bit each.
struct BrickSight {
  Slot slot = 0;
  BlockIndex block;
  int brick = 0;
  std::uint64_t through = 0;  // looked through
  std::uint64_t hit = 0;      // doubted before, and a surface was seen there
};

struct CarvedVoxels {
  Slot slot = 0;
  int brick = 0;
  std::uint64_t voxels = 0;
};

// Tells how a view sees the voxels of some bricks of one block (a bit each). Reads alone.
struct SightOfBlock {
  const FrameView& view;
  const SightTiles& tiles;
  const PanopticMap& map;

  void look(Slot slot, std::uint64_t bricks, std::vector<BrickSight>& sights) const;
};

// Takes down the sights of one view, in their order, and returns what has now been looked through from so many places. Two views
// are of two places if they look at the cell from directions that are 3 degrees apart.
std::vector<CarvedVoxels> carve(const std::vector<BrickSight>& sights, const Vec3d& camera_m, int views, FreeSpaceMap& space);

// Forgets these voxels, and marks their blocks as changed.
void clear(std::span<const CarvedVoxels> carved, VoxelMap& map);

}  // namespace panoptic
