// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// People who live in a map for a while and decide for themselves, without a browser: what `panoptic play` shows, for checks.
// Metres, in the z-up frame.
#pragma once

#include <string>
#include <vector>

#include "panoptic/home_plan.h"
#include "panoptic/planning.h"
#include "panoptic/planning/agent.h"
#include "panoptic/planning/insects.h"
#include "panoptic/planning/recast_mesh.h"

namespace panoptic {

struct AgentSample {
  double time_s = 0;
  AgentState state = AgentState::kStanding;
  Vec3d position = Vec3d::Zero();  // on the floor below the pelvis
  Vec2d facing = Vec2d::UnitX();
};

struct AgentTrack {
  std::vector<AgentSample> samples;  // every kAgentSample_s, from the beginning
  AgentTotals totals;
};

struct AgentsRun {
  std::vector<AgentTrack> agents;
  std::vector<InsectTrack> insects;
  std::vector<std::string> notes;  // a line each: what they could not do

  AgentTotals totals() const;
};

// REQUIRES a mesh with polygons, made for this size, and options that check() lets pass.
AgentsRun let_live(const RecastMesh& mesh, const HomePlan& home, const AgentSize& size, const AgentOptions& options);

}  // namespace panoptic
