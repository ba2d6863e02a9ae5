// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The program without the simulator (PANOPTIC_SIM=OFF): the commands that need one say so, and so does open_recording.
#include <fmt/format.h>

#include "apps/panoptic/commands.h"
#include "panoptic/error.h"
#include "panoptic/scan_truth.h"
#include "panoptic/simulation.h"

namespace panoptic {
namespace {

[[noreturn]] void needs_simulator(const char* command) {
  throw Error(fmt::format("{}: this program was built without the simulator; build it with -DPANOPTIC_SIM=ON", command));
}

}  // namespace

std::unique_ptr<Dataset> open_dataset(const std::string& path_or_simulation, const std::filesystem::path& calibration,
                                      std::optional<double> pair_tolerance_s) {
  return open_recording(path_or_simulation, calibration, pair_tolerance_s);
}

ScanTruth simulated_truth(const std::string& simulation) { needs_simulator(simulation.c_str()); }

int simulate(const Arguments& /*arguments*/) { needs_simulator("simulate"); }

int benchmark(const Arguments& /*arguments*/) { needs_simulator("benchmark"); }

}  // namespace panoptic
