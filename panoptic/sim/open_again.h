// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A recording that was mapped before, opened for its images.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "panoptic/io/recording_list.h"
#include "panoptic/simulation.h"
#include "panoptic/source.h"

namespace panoptic {

// Opens what open_dataset does; a recording without poses, whose camera was tracked, is opened too: its frames have the identity
// then.
inline std::unique_ptr<Dataset> open_again(const std::string& recording, const std::filesystem::path& calibration,
                                           std::optional<double> pair_tolerance_s) {
  if (is_recording_list(recording)) {
    return open_recording_list(recording, calibration, pair_tolerance_s, [](const ListedRecording& r) {
      return open_again(r.recording, r.calibration, r.pair_tolerance_s);
    });
  }
  try {
    return open_dataset(recording, calibration, pair_tolerance_s);
  } catch (const NoPoses&) {
    return open_without_poses(recording, calibration, pair_tolerance_s);
  }
}

}  // namespace panoptic
