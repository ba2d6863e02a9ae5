// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/frame_statistics.h"

#include <gtest/gtest.h>

namespace panoptic {
namespace {

TEST(FrameStatistics, TheTrajectoryIsWholeAsLongAsItFitsAndEvenAfterwards) {
  FrameStatistics log;
  for (std::uint64_t n = 0; n < 5 * FrameStatistics::kMaxPoses; ++n) {
    TimedPose pose;
    pose.time_s = static_cast<double>(n);
    log.count_used(pose);
    ASSERT_LE(log.trajectory().size(), FrameStatistics::kMaxPoses);
    ASSERT_TRUE(n >= FrameStatistics::kMaxPoses || log.trajectory().size() == n + 1);
  }
  const auto& poses = log.trajectory();
  EXPECT_EQ(poses.size(), 5 * FrameStatistics::kMaxPoses / 8);
  for (std::size_t i = 0; i < poses.size(); ++i) ASSERT_EQ(poses[i].time_s, static_cast<double>(8 * i));
  EXPECT_EQ(log.used(), 5 * FrameStatistics::kMaxPoses);
}

}  // namespace
}  // namespace panoptic
