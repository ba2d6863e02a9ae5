// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/home_plan.h"

#include "panoptic/planning/doors.h"
#include "panoptic/planning/footprints.h"
#include "panoptic/planning/rooms.h"
#include "panoptic/planning/seats.h"
#include "panoptic/planning/table_tops.h"
#include "panoptic/planning/walls.h"

namespace panoptic {

HomePlan plan_home(const PanopticMap& map, const Pose& grid_from_world) {
  return plan_home(map, surface_samples(map.voxels), grid_from_world);
}

HomePlan plan_home(const PanopticMap& map, const SurfaceByBlock& samples, const Pose& grid_from_world) {
  const LabelledSurface surface = labelled_surface(map, samples, grid_from_world);
  HomePlan plan;
  plan.grid_from_world = grid_from_world;
  const Pose world_from_grid = grid_from_world.inverse();
  const auto is_empty = [&](const Vec3d& p) { return seen_empty(map, world_from_grid * p); };
  plan.furniture = footprints(surface, is_empty);
  plan.table_tops = find_table_tops(surface, map.labels, is_empty);
  plan.seats = find_seats(surface, map.labels, plan.table_tops);
  plan.lying_places = find_lying_places(surface, map.labels);
  const OpenFloor floor = open_floor(map, surface, grid_from_world);
  const std::vector<WallPlane> planes = find_wall_planes(surface);
  plan.walls = wall_lines(planes, floor);
  plan.doors = find_doors(surface, map.labels, {planes, floor});
  add_rooms(floor, map.labels, plan);
  return plan;
}

}  // namespace panoptic
