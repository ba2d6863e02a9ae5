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

// Opens what open_dataset does. `is_tracked`: the camera was tracked, and what poses the recording has do not matter; frames then
// have the identity, but those of a simulated home. A list says it of each of its recordings.
inline std::unique_ptr<Dataset> open_again(const std::string& recording, const std::filesystem::path& calibration,
                                           std::optional<double> pair_tolerance_s, bool is_tracked) {
  if (is_recording_list(recording)) {
    return open_recording_list(recording, calibration, pair_tolerance_s, [](const ListedRecording& r) {
      return open_again(r.recording, r.calibration, r.pair_tolerance_s, r.tracked);
    });
  }
  if (!is_tracked || recording.starts_with("sim:")) return open_dataset(recording, calibration, pair_tolerance_s);
  return open_without_poses(recording, calibration, pair_tolerance_s);
}

}  // namespace panoptic
