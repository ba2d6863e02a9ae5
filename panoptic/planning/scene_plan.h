// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The part of a plan (docs/planning.md) that figures need who live in a map on a screen, as the bytes of its files.
#pragma once

#include <optional>
#include <string>

#include "panoptic/planning.h"
#include "panoptic/planning/surface_samples.h"

namespace panoptic {

struct ScenePlan {
  std::string navmesh;      // navmesh.bin
  std::string walls;        // walls.bin
  std::string walls_index;  // walls.json
  std::string affordances;  // affordances.json
};

// Throws Error as write_plan does, and if nowhere on the floor is there room for the agent.
ScenePlan scene_plan(const PanopticMap& map, const AgentSize& agent = {}, const std::optional<Vec3d>& up = {});
// The same from the surface: samples of the map's voxels, or those of a map whose voxels are not at hand.
ScenePlan scene_plan(const PanopticMap& map, const SurfaceByBlock& surface, const AgentSize& agent = {},
                     const std::optional<Vec3d>& up = {});

}  // namespace panoptic
