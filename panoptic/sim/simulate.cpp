// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include "panoptic/base/config.h"
#include "panoptic/sim/export.h"
#include "panoptic/simulation.h"

namespace panoptic {
namespace {

// The preset of the predictions brings its noise, which settings may then change.
ExportOptions options_from(const std::vector<std::string>& settings) {
  constexpr std::string_view kPredictions = "predictions=";
  ExportOptions options;
  for (const std::string& setting : settings) {
    if (!setting.starts_with(kPredictions)) continue;
    set_predictions(options, setting.substr(kPredictions.size()));
  }
  const Fields all = fields(options);
  for (const std::string& setting : settings) set_field(all, setting);
  return options;
}

}  // namespace

bool simulate(const std::filesystem::path& folder, const std::vector<std::string>& settings, const SimulationWatch& watch) {
  const ExportOptions options = options_from(settings);
  const Simulation simulation(simulation_options(options));
  return export_scan(simulation, options, folder, [&](std::size_t done) { return !watch || watch(done, simulation.size()); });
}

}  // namespace panoptic
