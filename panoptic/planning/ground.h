// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The ground of a map for one agent, and the ways over it (navigation.h for users).
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "panoptic/navigation.h"
#include "panoptic/planning/columns.h"
#include "panoptic/planning/recast_mesh.h"

namespace panoptic {

struct Ground {
  UpFrame frame;
  AgentSize agent;
  std::vector<GroundSample> samples;
  SolidColumns columns;                 // marked for the agent
  std::map<LabelSlot, PanopticId> ids;  // of the labels of samples
};

// Cells of about 4.8 cm, a whole number of voxels, for grids and distances; the ground has spots of half a cell.
double plan_cell_m(const VoxelMap& map);

Ground ground_of(const PanopticMap& map, const UpFrame& frame, const SurfaceByBlock& surface, const AgentSize& agent);

// A place where the agent may stand.
struct Foothold {
  Vec3d at_m = Vec3d::Zero();
  std::int32_t island = 0;
};

// The place nearest to a point, at most the radius away along the floor; nothing if there is none.
std::optional<Foothold> foothold(const Ground& ground, const Vec3d& point_m);
// Places within 1.5 m of an object, on this island, from which the object is seen; the nearest to the object.
std::optional<Foothold> foothold_beside(const Ground& ground, PanopticId object, std::int32_t island);

// NavigationMesh::path and path_to.
Path path_between(const Ground& ground, const RecastMesh& mesh, const Vec3d& from_m, const Vec3d& to_m);
Path path_beside(const Ground& ground, const RecastMesh& mesh, const Vec3d& from_m, PanopticId goal);

double walkable_area_m2(const SolidColumns& columns);
std::size_t island_count(const SolidColumns& columns);

}  // namespace panoptic
