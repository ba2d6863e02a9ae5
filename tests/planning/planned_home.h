// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A simulated home, mapped with perfect masks in a world that may be turned, and how its plan compares with the truth.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "panoptic/home_plan.h"
#include "panoptic/mapper.h"
#include "panoptic/sim/home_truth.h"
#include "panoptic/sim/simulation.h"

namespace panoptic::test {

// The map of the simulation's frames, seen by a smaller camera; the world is the simulation's, turned.
std::unique_ptr<Mapper> map_home(const Simulation& simulation, const Pose& turned_from_world);

// The plan in the axes of the simulation. REQUIRES a turn about the vertical or any other: the plan's own frame undoes it.
HomePlan in_world(HomePlan plan, const Pose& turned_from_world);

// Precision and recall by one-to-one matches, and how good those are.
struct Matches {
  int found = 0;
  int wanted = 0;
  int matched = 0;
  std::vector<double> errors;  // of the matches: degrees of facing, IoU, metres of width

  double f1() const { return found + wanted == 0 ? 1 : 2.0 * matched / (found + wanted); }
};

struct PlanScores {
  Matches seats;   // within 0.25 m from above; degrees between the facings
  Matches tables;  // IoU from above, of the best match above a half
  Matches doors;   // centres within 0.3 m; difference of the widths
  Matches rooms;   // IoU above 0.75
  int room_classes_right = 0;

  std::string text() const;
};

PlanScores score(const HomePlan& plan, const PlanTruth& truth);

}  // namespace panoptic::test
