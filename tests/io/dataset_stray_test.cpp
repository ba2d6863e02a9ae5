// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/io/video.h"
#include "panoptic/source.h"
#include "tests/fresh_folder.h"
#include "tests/io/phone_recordings.h"
#include "tests/io/small_video.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kJpeg = 6;  // how far its colours are off

std::string reason(const Dataset& dataset, std::size_t position) {
  const ReadResult result = dataset.read(position);
  return result.frame ? "frame" : result.skipped.reason;
}

TEST(StrayScanner, IsReadWithExtractedImages) {
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root);
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->description(), "Stray Scanner, 4 frames, depth 32x24, colour 48x36");
  for (int i = 0; i < kFrameCount; ++i) expect_phone_frame(dataset->read(static_cast<std::size_t>(i)), i, stray_camera(), kJpeg);
  EXPECT_DOUBLE_EQ(dataset->read(2).frame->time_s, 102.5);
  EXPECT_THAT(dataset->notes().assumed, ElementsAre());
  EXPECT_THAT(dataset->notes().left_out, ElementsAre(HasSubstr("% of the depth readings, whose confidence is the lowest")));
}

TEST(StrayScanner, TakesIntrinsicsThatStandInEachRow) {
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root, {.own_intrinsics = true});
  const auto dataset = open_recording(root);
  for (int i = 0; i < kFrameCount; ++i) expect_phone_frame(dataset->read(static_cast<std::size_t>(i)), i, stray_camera(i), kJpeg);
  fs::remove(root / "camera_matrix.csv");
  expect_phone_frame(open_recording(root)->read(2), 2, stray_camera(2), kJpeg);
}

// The convention itself, from OdometryEncoder.swift of Stray Scanner: the quaternion is ARKit's, of a camera that looks along its
// -z with y up, times half a turn about x, (1, 0, 0, 0). The world has y up. ARKit begins looking along the world's -z.
TEST(StrayScanner, HasPosesOfArkitWithTheCameraTurnedOver) {
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root);
  write_depth(root / "depth/000000.png", flat_depth(3000));
  write_depth(root / "depth/000001.png", flat_depth(3000));
  // The second is ARKit's camera turned to the left by 90 degrees, (0, s, 0, c) * (1, 0, 0, 0) = (c, 0, -s, 0): along -x.
  constexpr double kHalf = 0.70710678118654752;
  write_text(root / "odometry.csv", fmt::format("timestamp, frame, x, y, z, qx, qy, qz, qw\n1, 000000, 0, 0, 0, 1, 0, 0, 0\n"
                                                "2, 000001, 5, 1, 2, {0}, 0, {1}, 0\n",
                                                kHalf, -kHalf));
  fs::remove_all(root / "rgb");
  for (int i = 0; i < 2; ++i) write_color(root / fmt::format("rgb/{:06}.jpg", i), color_image(i));
  const auto dataset = open_recording(root);
  const Frame ahead = *dataset->read(0).frame;
  EXPECT_NEAR(seen_at(ahead, 15, 12).z(), -3, 1e-6);
  EXPECT_GT(seen_at(ahead, 31, 12).x(), 1);  // what is right in the image
  EXPECT_GT(seen_at(ahead, 15, 1).y(), 1);   // what is up in the image
  const Frame left = *dataset->read(1).frame;
  EXPECT_NEAR(seen_at(left, 15, 12).x(), 2, 1e-6);
  EXPECT_LT(seen_at(left, 31, 12).z(), 1);
  EXPECT_GT(seen_at(left, 15, 1).y(), 2);
}

TEST(StrayScanner, IsReadWithItsVideo) {
  if (!reads_videos()) GTEST_SKIP() << "this build reads no videos (PANOPTIC_VIDEO)";
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root, {.images = false});
  std::vector<Image<Rgb>> images;
  for (int i = 0; i < kFrameCount; ++i) images.push_back(color_image(i));
  if (!write_video(root / "rgb.mp4", images)) GTEST_SKIP() << "this FFmpeg has no encoder libx264rgb";
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->description(), "Stray Scanner, 4 frames, depth 32x24, colour 48x36");
  for (const int i : {3, 0, 2, 1}) expect_phone_frame(dataset->read(static_cast<std::size_t>(i)), i, stray_camera());
  images.pop_back();
  write_video(root / "rgb.mp4", images);
  const auto shorter = open_recording(root);
  EXPECT_THAT(shorter->notes().assumed,
              ElementsAre("rgb.mp4 has 3 images and odometry.csv 4 rows: the n-th image belongs to the n-th row"));
  EXPECT_EQ(reason(*shorter, 2), "frame");
  EXPECT_EQ(reason(*shorter, 3), "colour image missing: rgb.mp4 has 3 images");
  write_text(root / "rgb.mp4", "cut off");
  EXPECT_THAT(error_of(root), HasSubstr("no video that can be read"));
}

TEST(StrayScanner, IsRefusedWithTheRemedyWhereVideosAreNotRead) {
  if (reads_videos()) GTEST_SKIP() << "this build reads videos";
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root, {.images = false});
  write_text(root / "rgb.mp4", "video");
  EXPECT_THAT(error_of(root), HasSubstr("ffmpeg -ignore_editlist 1 -noautorotate -i"));
}

TEST(StrayScanner, KnowsWhichExtractedImageIsWhich) {
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root, {.first_image = 1});  // as many: in order
  expect_phone_frame(open_recording(root)->read(2), 2, stray_camera(), kJpeg);
  fs::remove(root / "rgb/000004.jpg");  // images 1, 2, 3 of frames 0, 1, 2, 3
  EXPECT_THAT(error_of(root),
              HasSubstr("3 images for the 4 images of the video, so that it is open which is which; extract all: ffmpeg"));
  fs::remove(root / "rgb/000002.jpg");  // 1 and 3: chosen ones
  const auto dataset = open_recording(root);
  EXPECT_EQ(reason(*dataset, 0), "colour image missing");
  EXPECT_EQ(reason(*dataset, 3), "frame");
  write_color(root / "rgb/000009.jpg", color_image(0));
  EXPECT_THAT(error_of(root), HasSubstr("it is open which is which"));
}

TEST(StrayScanner, HasTheMatrixOfImagesThatWereMadeSmaller) {
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root);
  write_text(root / "camera_matrix.csv", "1400, 0, 950\n0, 1400, 730\n0, 0, 1\n");
  expect_phone_frame(open_recording(root)->read(1), 1, {1920, 1440, 1400, 1400, 950, 730}, kJpeg);
  for (int i = 0; i < kFrameCount; ++i) write_color(root / fmt::format("rgb/{:06}.jpg", i), color_image(i, {36, 48}));
  EXPECT_THAT(error_of(root),
              HasSubstr("not near the middle of the 36x48 images; were they turned or cut? Extract them as they are: ffmpeg"));
}

TEST(StrayScanner, SkipsFramesWithDamagedParts) {
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root);
  fs::remove(root / "depth/000000.png");
  write_confidence(root / "confidence/000001.png", confidence_image({16, 12}));
  write_depth(root / "depth/000009.png", raw_depth(0));
  std::string odometry = read_file(root / "odometry.csv");
  const std::size_t row = odometry.find("102.5, 000002, ") + 15;
  odometry.replace(row, odometry.find(',', row) - row, "nan");
  write_text(root / "odometry.csv", odometry);
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 5U);
  EXPECT_EQ(reason(*dataset, 0), "depth image missing");
  EXPECT_EQ(reason(*dataset, 1), "confidence image is 16x12, and the depth image 32x24");
  EXPECT_EQ(reason(*dataset, 2), "pose is not finite");
  EXPECT_EQ(reason(*dataset, 3), "frame");
  EXPECT_EQ(reason(*dataset, 4), "no pose: odometry.csv has no row of this frame");
}

TEST(StrayScanner, SaysWhatIsWrongWithItsTables) {
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root);
  write_text(root / "odometry.csv", "timestamp, frame, x, y, z, qx, qy, qz, qw\n1, 0, 0, 0, 0, 1, 0, 0, 0\n2, 1, 0, 0\n");
  EXPECT_THAT(error_of(root), HasSubstr("odometry.csv:3: 4 words, expected 9; is the line cut off? Take it out"));
  write_text(root / "odometry.csv", "qw, qx, qy, qz, x, y, z, frame, timestamp\n1, 0, 0, 0, 0, 0, 0\n");
  EXPECT_THAT(error_of(root), HasSubstr("odometry.csv:2: 7 words, expected 9"));
  write_text(root / "odometry.csv", "timestamp, frame, x, y\n1, 0, 0, 0\n");
  EXPECT_THAT(error_of(root), HasSubstr("odometry.csv:1: expected a heading with x, y, z, qx, qy, qz, qw"));
  write_text(root / "odometry.csv",
             "timestamp, frame, x, y, z, qx, qy, qz, qw\n1, 3, 0, 0, 0, 1, 0, 0, 0\n2, 3, 0, 0, 0, 1, 0, 0, 0\n");
  fs::remove_all(root / "rgb");
  for (int i = 0; i < 2; ++i) write_color(root / fmt::format("rgb/{}.png", i), color_image(i));
  EXPECT_THAT(error_of(root), HasSubstr("two rows of frame 3; take one out"));
  fs::remove(root / "odometry.csv");
  EXPECT_THAT(error_of(root), HasSubstr("Stray Scanner recording without odometry.csv"));
  write_stray(root);
  fs::remove(root / "odometry.csv");
  fs::remove(root / "rgb/0.png");
  fs::remove(root / "rgb/1.png");
  EXPECT_EQ(reason(*open_without_poses(root), 3), "frame");
}

TEST(StrayScanner, OfTheFirstVersionsHasNoHeading) {
  const fs::path root = fresh_folder("71de12f9");
  write_stray(root);
  std::string odometry;
  for (int i = 0; i < kFrameCount; ++i) odometry += fmt::format("{}, 0, 0, 1, 0, 0, 0\n", i);
  write_text(root / "odometry.csv", odometry);
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->read(3).frame->world_from_camera.translation(), Vec3d(3, 0, 0));
}

}  // namespace
}  // namespace panoptic::test
