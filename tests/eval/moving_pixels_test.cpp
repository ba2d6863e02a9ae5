// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/moving_pixels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/io/dynamics.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;

constexpr Camera kCamera{40, 32, 40, 40, 19.5, 15.5};
const Eigen::AlignedBox3d kBox(Vec3d(-4, -4, -1), Vec3d(4, 4, 6));

// A wall two metres ahead; in the left half something half a metre nearer.
Frame wall_frame(std::int64_t index, double time_s) {
  Frame frame;
  frame.index = index;
  frame.time_s = time_s;
  frame.depth_camera = frame.color_camera = kCamera;
  Image<float> depth(kCamera.width, kCamera.height, 2.0F);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width / 2; ++u) depth(u, v) = 1.5F;
  }
  depth(39, 31) = 0;
  frame.depth = std::move(depth);
  frame.color = Image<Rgb>(kCamera.width, kCamera.height);
  return frame;
}

Image<std::uint16_t> columns(int from, int to) {
  Image<std::uint16_t> mask(kCamera.width, kCamera.height);
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = from; u < to; ++u) mask(u, v) = 255;
  }
  return mask;
}

TEST(FirstSeen, IsTheTimeOfTheFirstFrameThatShowsThePlaceEmptyOrNot) {
  FirstSeen seen(kBox);
  seen.look(wall_frame(0, 10));
  seen.look(wall_frame(1, 12));
  EXPECT_EQ(seen.seconds({0.3, 0, 1.0}, 13), 3.0);   // on the way to the wall
  EXPECT_EQ(seen.seconds({0.3, 0, 1.99}, 13), 3.0);  // the wall
  EXPECT_FALSE(seen.seconds({0.3, 0, 2.5}, 13));     // behind it
  EXPECT_FALSE(seen.seconds({3, 0, 1.0}, 13));       // beside the picture
  EXPECT_FALSE(seen.seconds({30, 0, 1.0}, 13));      // outside of the box
}

TEST(MovingPixels, AreCountedInEverySecondColumnAndRow) {
  FirstSeen seen(kBox);
  seen.look(wall_frame(0, 0));
  MovingPixels pixels;
  count_moving(wall_frame(1, 2), columns(0, 20), columns(10, 40), seen, pixels);
  // 16 rows; columns 10 to 18 in both, 0 to 8 only true, 20 to 38 only claimed.
  EXPECT_EQ(pixels.both, 5U * 16U);
  EXPECT_EQ(pixels.true_only, 5U * 16U);
  EXPECT_EQ(pixels.claimed_only, 10U * 16U);
  EXPECT_NEAR(*pixels.precision(), 1.0 / 3, 1e-12);
  EXPECT_NEAR(*pixels.recall(), 0.5, 1e-12);
  EXPECT_NEAR(*pixels.f1(), 0.4, 1e-12);
}

TEST(MovingPixels, DoNotCountUntilThePlaceIsKnownForASecond) {
  FirstSeen seen(kBox);
  seen.look(wall_frame(0, 0));
  MovingPixels pixels;
  count_moving(wall_frame(1, 0.9), columns(0, 20), columns(0, 40), seen, pixels);
  EXPECT_EQ(pixels.both + pixels.true_only + pixels.claimed_only, 0U);
  EXPECT_FALSE(pixels.f1());
}

// The frames 0 and 60, two seconds apart.
class TwoFrames : public Dataset {
 public:
  std::string description() const override { return "two frames"; }
  std::size_t size() const override { return 2; }
  ReadResult read(std::size_t position) const override {
    return {wall_frame(60 * static_cast<std::int64_t>(position), 2.0 * static_cast<double>(position)), {}};
  }
};

TEST(MovingPixels, FoldersAreComparedFrameByFrame) {
  const std::filesystem::path truth = fresh_folder("truth");
  const std::filesystem::path claims = fresh_folder("claims");
  for (const std::int64_t frame : {0, 60}) write_png(truth / moving_mask_name(frame), columns(0, 20));
  EXPECT_THAT(error_of([&] { score_moving(TwoFrames(), truth, claims, kBox); }), HasSubstr("--write-moving"));
  write_png(claims / moving_mask_name(60), columns(0, 10));
  const MovingPixels pixels = score_moving(TwoFrames(), truth, claims, kBox);
  EXPECT_EQ(pixels.frames, 1U);
  EXPECT_EQ(pixels.without_mask, 1U);
  EXPECT_EQ(pixels.precision(), 1.0);
  EXPECT_EQ(pixels.recall(), 0.5);
  write_png(claims / moving_mask_name(0), Image<std::uint16_t>(3, 3));
  EXPECT_THAT(error_of([&] { score_moving(TwoFrames(), truth, claims, kBox); }), HasSubstr("3 x 3"));
  std::filesystem::remove(truth / moving_mask_name(0));
  EXPECT_THAT(error_of([&] { score_moving(TwoFrames(), truth, claims, kBox); }), HasSubstr("000000.png"));
}

}  // namespace
}  // namespace panoptic::test
