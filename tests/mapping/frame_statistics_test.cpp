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

TEST(FrameStatistics, CountsTheFramesUntilATime) {
  FrameStatistics frames;
  EXPECT_EQ(frames.used_until(5), 0U);
  for (int n = 0; n < 90; ++n) frames.count_used({n / 30.0});
  EXPECT_EQ(frames.used_until(-1), 0U);
  EXPECT_EQ(frames.used_until(0), 1U);
  EXPECT_EQ(frames.used_until(1), 31U);
  EXPECT_EQ(frames.used_until(9), 90U);
  for (std::uint64_t n = 90; n < 2 * FrameStatistics::kMaxPoses; ++n) frames.count_used({static_cast<double>(n) / 30});
  EXPECT_EQ(frames.used_until(1), 31U) << "every second pose is left out";
  EXPECT_LE(frames.used_until(1e9), frames.used());
}

}  // namespace
}  // namespace panoptic
