// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Statistics of the frames that were used, with their poses, and of those that were not, in bounded memory.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/source.h"

namespace panoptic {

struct TimedPose {
  double time_s = 0;
  Pose world_from_camera = Pose::Identity();  // the depth camera
  std::int64_t frame = 0;                     // its number in the recording
};

class FrameStatistics {
 public:
  static constexpr std::size_t kMaxListed = 1000;

  static constexpr std::size_t kMaxPoses = 20000;

  void count_used(const TimedPose& pose);
  // Counts a frame that was not used. Reasons are counted by their text up to the first ':'; the rest names the file.
  void count_skipped(const SkippedFrame& frame);

  // The poses of all used frames, in their order, as they are now.
  void retrace(const std::vector<TimedPose>& poses);

  std::uint64_t used() const { return used_; }
  std::uint64_t skipped() const { return skipped_; }
  const std::map<std::string, std::uint64_t>& skipped_by_reason() const { return by_reason_; }
  const std::vector<SkippedFrame>& first_skipped() const { return first_; }  // at most kMaxListed
  // Poses of the used frames in their order: of all of them, of every second, every fourth ... as kMaxPoses allows.
  const std::vector<TimedPose>& trajectory() const { return trajectory_; }
  // The time of a used frame, seconds of the recording; where poses are left out, of the one before it.
  double time_of(std::int64_t frame) const;
  // How many of the used frames, the first ones, are no later than this; to the frames that the trajectory has.
  std::uint64_t used_until(double time_s) const;

 private:
  std::uint64_t used_ = 0;
  std::uint64_t pose_every_ = 1;
  std::vector<TimedPose> trajectory_;
  std::uint64_t skipped_ = 0;
  std::map<std::string, std::uint64_t> by_reason_;
  std::vector<SkippedFrame> first_;
};

}  // namespace panoptic
