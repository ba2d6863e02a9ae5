// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The report of a run whose poses were tracked.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/camera_tracker.h"

namespace panoptic {

// Frames that followed one another in one state.
struct TrackingSpan {
  TrackingState state = TrackingState::kLost;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
  std::size_t frames = 0;
  std::string reason;        // of the first, if they are lost
  double least_quality = 1;  // CameraPose::quality
};

struct TrackingReport {
  std::size_t tracked = 0;  // frames whose pose is known
  std::size_t lost = 0;
  std::size_t keyframes = 0;
  double mean_quality = 0;
  std::vector<TrackingSpan> spans;
  std::vector<Loop> loops;
  std::vector<FramePose> given;  // the poses of the recording, which were not used; none if it has none
};

}  // namespace panoptic
