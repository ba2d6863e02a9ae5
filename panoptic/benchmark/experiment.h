// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Simulated homes mapped under named settings and scored against their exact truth.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/benchmark/substitutes.h"
#include "panoptic/evaluation.h"
#include "panoptic/options.h"
#include "panoptic/sim/simulation.h"

namespace panoptic {

struct Setting {
  std::string name;
  std::string noise = "kinect";                           // sensor_noise_preset
  std::string predictions = "maskrcnn";                   // prediction_noise_preset
  std::string preset = kDefaultPreset;                    // preset_options
  std::vector<std::string> set;                           // options that differ from the preset, key=value
  std::optional<Substitutes> substitutes = std::nullopt;  // stages replaced by the truth; then there is no regularizer
};

struct Experiment {
  std::vector<SimulationOptions> homes;  // their noise is that of each setting
  std::vector<Setting> settings;
};

// The result of a setting over all homes.
struct SettingResult {
  Setting setting;
  Scores scores;
  double fusion_p50_ms = 0;     // mean over the homes; 0 with substitutes
  double regularize_ms = 0;     // mean of a run of the regularizer; 0 without
  double map_mb = 0;            // of the largest map
  std::size_t objects = 0;      // in all maps together
  std::size_t true_things = 0;  // things with 100 vertices or more in all truths together
};

// Outcomes in the order of the settings. A few settings at a time share the simulation of a home's frames. `progress` hears the
// frames mapped so far and of how many; if it returns false the experiment stops and the result is empty. Throws Error (unknown
// preset or option, package missing).
std::vector<SettingResult> run(const Experiment& experiment, const std::function<bool(std::size_t, std::size_t)>& progress);

}  // namespace panoptic
