// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/run_tracker.h"

#include <fmt/format.h>

#include <algorithm>

namespace panoptic {

Outcome RunTracker::locate(Frame& frame, const VoxelMap& map, const std::optional<Pose>& given) {
  if (given) report_.given.push_back({frame.index, frame.time_s, *given});
  frame.world_from_camera = Pose::Identity();
  if (Outcome outcome = check(frame); !outcome.used) return outcome;
  const CameraPose pose = tracker_.track(frame, map);
  count(frame.index, pose);
  if (!pose.is_known()) return Outcome::refused(fmt::format("the camera is lost: {}", pose.reason));
  frame.world_from_camera = pose.world_from_camera;
  return {};
}

void RunTracker::count(std::int64_t frame, const CameraPose& pose) {
  (pose.is_known() ? report_.tracked : report_.lost) += 1;
  if (pose.is_known()) quality_sum_ += pose.quality;
  if (report_.spans.empty() || report_.spans.back().state != pose.state) {
    report_.spans.push_back({.state = pose.state, .first_frame = frame, .reason = pose.reason});
  }
  TrackingSpan& span = report_.spans.back();
  span.last_frame = frame;
  ++span.frames;
  span.least_quality = std::min(span.least_quality, pose.quality);
}

std::vector<PoseUpdate> RunTracker::corrections() {
  std::vector<PoseUpdate> updates;
  const auto poses = tracker_.corrected_poses();
  if (!poses) return updates;
  for (const FramePose& pose : *poses) updates.push_back({pose.frame, pose.world_from_camera});
  return updates;
}

TrackingReport RunTracker::report() const {
  TrackingReport report = report_;
  report.keyframes = tracker_.keyframes();
  report.loops = tracker_.loops();
  report.mean_quality = report.tracked > 0 ? quality_sum_ / static_cast<double>(report.tracked) : 0;
  return report;
}

}  // namespace panoptic
