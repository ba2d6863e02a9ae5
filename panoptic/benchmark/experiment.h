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

#include "panoptic/base/json.h"
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

// The share of an experiment that is worked on at once: one home under a few settings of equal noise, which share its frames.
struct ExperimentPart {
  std::size_t home = 0;               // index into the experiment's homes
  std::vector<std::size_t> settings;  // indices
  bool is_first_of_home = false;
};
std::vector<ExperimentPart> parts_of(const Experiment& experiment);

// The outcome of a part, for whoever puts them together.
struct PartCounts {
  Evaluation evaluation;
  double fusion_p50_ms = 0;
  double regularize_ms = 0;
  double map_mb = 0;
  std::size_t objects = 0;
};
struct PartResult {
  std::vector<PartCounts> counts;  // of the part's settings
  std::size_t true_things = 0;     // of its home
};
Json to_json(const PartResult& result);
PartResult part_result_in(const Json& json, const std::string& file);  // throws Error

// Throws Error for an unknown preset or option, before hours are spent.
void require_sound(const Experiment& experiment);

// `progress` hears the frames mapped so far and of how many; if it returns false the part stops and there is no result. Throws
// Error (unknown preset or option, package missing).
std::optional<PartResult> run_part(const Experiment& experiment, const ExperimentPart& part,
                                   const std::function<bool(std::size_t, std::size_t)>& progress);

// Outcomes in the order of the settings. REQUIRES a result for each of parts_of, in their order.
std::vector<SettingResult> outcomes_of(const Experiment& experiment, const std::vector<PartResult>& results);

}  // namespace panoptic
