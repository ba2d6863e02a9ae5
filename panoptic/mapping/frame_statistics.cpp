// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/frame_statistics.h"

#include <algorithm>
#include <iterator>

namespace panoptic {

void FrameStatistics::count_used(const TimedPose& pose) {
  if (used_ % pose_every_ == 0) {
    trajectory_.reserve(kMaxPoses);  // all at once: a long run shall hold no more than a short one
    if (trajectory_.size() == kMaxPoses) {
      for (std::size_t i = 0; 2 * i < kMaxPoses; ++i) trajectory_[i] = trajectory_[2 * i];
      trajectory_.resize(kMaxPoses / 2);
      pose_every_ *= 2;
    }
    trajectory_.push_back(pose);
  }
  ++used_;
}

double FrameStatistics::time_of(std::int64_t frame) const {
  const auto after = std::upper_bound(trajectory_.begin(), trajectory_.end(), frame,
                                      [](std::int64_t number, const TimedPose& pose) { return number < pose.frame; });
  if (after != trajectory_.begin()) return std::prev(after)->time_s;
  return trajectory_.empty() ? 0 : trajectory_.front().time_s;
}

// Times mostly ascend, and it is mostly asked for a moment ago.
std::uint64_t FrameStatistics::used_until(double time_s) const {
  constexpr double kRounding_s = 1e-3;
  std::size_t count = trajectory_.size();
  while (count > 0 && trajectory_[count - 1].time_s > time_s + kRounding_s) --count;
  return count == 0 ? 0 : (count - 1) * pose_every_ + 1;
}

void FrameStatistics::retrace(const std::vector<TimedPose>& poses) {
  used_ = 0;
  pose_every_ = 1;
  trajectory_.clear();
  for (const TimedPose& pose : poses) count_used(pose);
}

void FrameStatistics::count_skipped(const SkippedFrame& frame) {
  ++skipped_;
  ++by_reason_[frame.reason.substr(0, frame.reason.find(':'))];
  if (first_.size() < kMaxListed) first_.push_back(frame);
}

}  // namespace panoptic
