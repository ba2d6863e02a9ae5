// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The home from above in cells of two voxels: where there is wall, and where there is room beside the walls.
#pragma once

#include "panoptic/base/flat_grid.h"
#include "panoptic/map.h"
#include "panoptic/planning/labelled_surface.h"

namespace panoptic {

struct OpenFloor {
  FlatGrid grid;
  CellSet wall;  // a wall's surface at a person's height
  CellSet open;  // no wall, and the floor was seen, or empty space at a person's height

  bool is_open(const Vec2d& p) const;
  // Whether there is wall within a distance.
  bool has_wall_near(const Vec2d& p, double distance_m) const;
};

OpenFloor open_floor(const PanopticMap& map, const LabelledSurface& surface, const Pose& grid_from_world);

// Whether a point of the world was seen to be empty: by its voxel, or by its cell of free space.
bool seen_empty(const PanopticMap& map, const Vec3d& in_world);

}  // namespace panoptic
