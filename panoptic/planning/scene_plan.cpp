// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/scene_plan.h"

#include <fmt/format.h>

#include <vector>

#include "panoptic/error.h"
#include "panoptic/planning/ground.h"
#include "panoptic/planning/home_plan.h"
#include "panoptic/planning/plan_files.h"
#include "panoptic/planning/recast_mesh.h"
#include "panoptic/planning/surface_samples.h"
#include "panoptic/planning/up_frame.h"
#include "panoptic/planning/wall_meshes.h"

namespace panoptic {

ScenePlan scene_plan(const PanopticMap& map, const AgentSize& agent, const std::optional<Vec3d>& up) {
  return scene_plan(map, surface_samples(map.voxels), agent, up);
}

ScenePlan scene_plan(const PanopticMap& map, const SurfaceByBlock& surface, const AgentSize& agent,
                     const std::optional<Vec3d>& up) {
  check(agent);
  const UpFrame frame = up_frame(map, surface, up);
  const Ground ground = ground_of(map, frame, surface, agent);
  const RecastMesh floor(ground.columns, agent);
  if (!floor.has_polygons()) {
    throw Error(fmt::format("nowhere on the floor of this map is there room for a figure of {} m and a radius of {} m",
                            agent.height_m, agent.radius_m));
  }
  const std::vector<WallMesh> walls = wall_meshes(map, frame, surface);
  return {.navmesh = floor.bytes(),
          .walls = wall_bytes(walls),
          .walls_index = walls_json(walls, frame).dump(),
          .affordances = affordances_json(plan_home(map, surface, frame.grid_from_world)).dump()};
}

}  // namespace panoptic
