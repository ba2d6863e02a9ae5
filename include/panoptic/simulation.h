// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Frames by name: recordings on disk and simulated homes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/source.h"

namespace panoptic {

// A path opens a recording (source.h, open_recording); "sim:SEED" simulates a home (docs/simulator.md),
// which takes no calibration and has no images to pair. Throws Error.
std::unique_ptr<Dataset> open_dataset(const std::string& path_or_simulation, const std::filesystem::path& calibration = {},
                                      std::optional<double> pair_tolerance_s = {});

// Hears how many frames of how many are done; false ends the simulation.
using SimulationWatch = std::function<bool(std::size_t done, std::size_t frames)>;

// Writes a simulated home to the folder, which must be absent or empty, as a ScanNet scan with truth and predictions beside it,
// as `panoptic simulate` does. `settings`: "seed=7", "rooms=2", "predictions=none" ..., by the names in its simulation.toml.
// Nothing is left there, and false returned, if the watch ends it. Throws Error.
bool simulate(const std::filesystem::path& folder, const std::vector<std::string>& settings, const SimulationWatch& watch = {});

}  // namespace panoptic
