// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Navigation meshes on walls, for those who crawl on them.
#pragma once

#include <vector>

#include "panoptic/planning/recast_mesh.h"

namespace panoptic {

// A wall as a ground of its own: its z leads out of the wall, its y up, its surface lies near z = 0.
struct WallMesh {
  Pose wall_from_grid = Pose::Identity();
  double area_m2 = 0;  // of the wall's surface
  RecastMesh mesh;
};

// A fly or a beetle.
inline constexpr AgentSize kInsect = {.radius_m = 0.02, .height_m = 0.05, .climb_m = 0.02};

// The planes of upright surface of class wall (without such a label in the map: of any surface), half a square metre at least,
// the largest first.
std::vector<WallMesh> wall_meshes(const PanopticMap& map, const UpFrame& frame, const SurfaceByBlock& surface);

}  // namespace panoptic
