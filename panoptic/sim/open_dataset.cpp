// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/simulation.h"

#include <fmt/format.h>

#include "panoptic/error.h"
#include "panoptic/io/recording_list.h"
#include "panoptic/sim/simulation.h"

namespace panoptic {

std::unique_ptr<Dataset> open_dataset(const std::string& path_or_simulation, const std::filesystem::path& calibration,
                                      std::optional<double> pair_tolerance_s) {
  if (is_recording_list(path_or_simulation)) {
    return open_recording_list(path_or_simulation, calibration, pair_tolerance_s, [](const ListedRecording& r) {
      require_posed(r);
      return open_dataset(r.recording, r.calibration, r.pair_tolerance_s);
    });
  }
  if (!path_or_simulation.starts_with("sim:")) return open_recording(path_or_simulation, calibration, pair_tolerance_s);
  if (!calibration.empty()) {
    throw Error(fmt::format("{}: a simulated home needs no calibration; leave out {}", path_or_simulation, calibration.string()));
  }
  return std::make_unique<Simulation>(parse_simulation(path_or_simulation));
}

}  // namespace panoptic
