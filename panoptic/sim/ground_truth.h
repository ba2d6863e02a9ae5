// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Builds the ground-truth mesh of a home frame by frame; ground_truth() in simulation.h does so for all frames at once.
#pragma once

#include <string>
#include <vector>

#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/map.h"
#include "panoptic/scan_truth.h"
#include "panoptic/sim/simulation.h"

namespace panoptic {

// "scene0007_00" for seed 7.
std::string scene_name(std::uint64_t seed);

// Fuses noise-free depth and colour from the true poses, by the real integrator. Not thread-safe.
class TruthBuilder {
 public:
  TruthBuilder();

  void add(const SimulatedFrame& simulated);

  // Meshes what was seen and asks the scene what each vertex is: kUnknown and instance 0 where no surface lies within 5 cm.
  ScanTruth finish(const Simulation& simulation) const;

 private:
  PanopticMap map_;  // without objects
  Registration registration_;
  Integrator integrator_;
  std::vector<LabelSlot> no_votes_;
};

}  // namespace panoptic
