// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The real recordings, where they are there.
#include <gtest/gtest.h>

#include <algorithm>

#include "panoptic/profile.h"
#include "panoptic/source.h"
#include "tests/places.h"
#include "tests/sanitized.h"
#include "tests/shared_data.h"

namespace panoptic::test {
namespace {

float median_m(const Frame& frame) {
  std::vector<float> readings;
  for (int v = 0; v < frame.depth.height(); ++v) {
    const float* row = frame.depth.row(v);
    std::copy_if(row, row + frame.depth.width(), std::back_inserter(readings), [](float z) { return z > 0; });
  }
  std::nth_element(readings.begin(), readings.begin() + static_cast<std::ptrdiff_t>(readings.size() / 2), readings.end());
  return readings[readings.size() / 2];
}

void expect_usable(const Dataset& dataset) {
  for (std::size_t i = 0; i < dataset.size(); i += 20) {
    const ReadResult result = dataset.read(i);
    ASSERT_TRUE(result.frame) << result.skipped.reason;
    EXPECT_EQ(check(*result.frame).reason, "");
    EXPECT_TRUE(is_rigid(result.frame->world_from_camera, 1e-9));
    EXPECT_GT(median_m(*result.frame), 0.5F) << i;
    EXPECT_LT(median_m(*result.frame), 5.0F) << i;
  }
}

TEST(Recordings, TheKitchenOpensWithItsCalibration) {
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  const auto dataset = open_recording(shared_folder() / "data" / "kitchen", source_folder() / "configs/kitchen.toml");
  EXPECT_EQ(dataset->description(), "7-Scenes / 3DMatch, 500 frames, depth 640x480, colour 640x480");
  ASSERT_EQ(dataset->size(), 500U);
  expect_usable(*dataset);
  EXPECT_EQ(dataset->read(0).frame->color_camera, (Camera{640, 480, 525.74, 525.74, 322.97, 236.51}));
}

TEST(Recordings, TheHololensRecordingOpensAsAPlainFolder) {
  PANOPTIC_REQUIRE_SHARED("data/hololens");
  const auto dataset = open_recording(shared_folder() / "data" / "hololens");
  EXPECT_EQ(dataset->description(), "plain folder, 200 frames, depth 540x360, colour 540x360");
  ASSERT_EQ(dataset->size(), 200U);
  expect_usable(*dataset);
  EXPECT_EQ(dataset->read(0).frame->index, 3);  // the numbers in the names do not start at 0
}

TEST(Recordings, StreamingHoldsAFewFramesAtATime) {
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  if (test::kSanitized) GTEST_SKIP() << "sanitizers keep freed memory";
  const auto dataset = open_recording(shared_folder() / "data" / "kitchen");
  FrameStream stream(*dataset, {0, 70, 1});
  for (int i = 0; i < 20; ++i) stream.next();
  const double before_mb = peak_rss_mb();
  while (stream.next()) {
  }
  EXPECT_LT(peak_rss_mb() - before_mb, 15);  // 50 frames more are 108 MB
}

}  // namespace
}  // namespace panoptic::test
