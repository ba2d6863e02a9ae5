// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Frames by name: recordings on disk and simulated homes.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "panoptic/source.h"

namespace panoptic {

// A path opens a recording (source.h, open_recording); "sim:SEED" simulates a home (docs/simulator.md),
// which takes no calibration and has no images to pair. Throws Error.
std::unique_ptr<Dataset> open_dataset(const std::string& path_or_simulation, const std::filesystem::path& calibration = {},
                                      std::optional<double> pair_tolerance_s = {});

}  // namespace panoptic
