// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Tracks the camera of a run: every frame gets its pose before it is mapped, and the map follows when a loop corrects poses.
#pragma once

#include <optional>
#include <vector>

#include "panoptic/camera_tracker.h"
#include "panoptic/outcome.h"
#include "panoptic/pose_update.h"
#include "panoptic/tracked_run.h"

namespace panoptic {

class RunTracker {
 public:
  explicit RunTracker(const CameraTrackerOptions& options) : tracker_(options) {}

  // A frame of an earlier visit, with its pose (CameraTracker::remember).
  void remember(const Frame& frame) { tracker_.remember(frame); }

  // Sets the pose of the next frame. Refused where the camera is lost: the frame must not be mapped. `given`: the pose that the
  // recording gives, for the report alone.
  Outcome locate(Frame& frame, const VoxelMap& map, const std::optional<Pose>& given);

  // The frame that was located last is in the map.
  void keep(const Frame& frame) { tracker_.keep(frame); }

  // The poses that the map must follow before the next frame; none if nothing was corrected.
  std::vector<PoseUpdate> corrections();

  TrackingReport report() const;

 private:
  void count(std::int64_t frame, const CameraPose& pose);

  CameraTracker tracker_;
  TrackingReport report_;
  double quality_sum_ = 0;
};

}  // namespace panoptic
