// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The files about the path of the camera: trajectory.txt, loops.json, given_trajectory.txt, and their part of report.json.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/tracked_run.h"

namespace panoptic {

Json to_json(const TrackingReport& tracking);

// The form of the TUM RGB-D benchmark.
std::string trajectory_text(const std::vector<TimedPose>& trajectory);

// Loops, and beside the trajectory the one that the recording has. Removes those of an earlier run.
void write_tracking(const std::filesystem::path& folder, const std::optional<TrackingReport>& tracking);

}  // namespace panoptic
