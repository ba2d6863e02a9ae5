// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "panoptic/error.h"
#include "panoptic/source.h"
#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string error_of(const fs::path& path) {
  try {
    open_recording(path);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

std::string reason(const Dataset& dataset, std::size_t position) {
  const ReadResult result = dataset.read(position);
  return result.frame ? "frame" : result.skipped.reason;
}

TEST(TumReader, ReadsFramesWhoseListsDisagreeByMilliseconds) {
  const fs::path root = fresh_folder("rgbd_dataset_freiburg1_desk");
  write_tum(root);
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 4U);
  for (int i = 0; i < kFrameCount; ++i) expect_frame(dataset->read(static_cast<std::size_t>(i)), i, 5000);
  EXPECT_DOUBLE_EQ(dataset->read(1).frame->time_s, 1001);
  EXPECT_NEAR(dataset->read(0).frame->depth_camera.fx, 517.3 * 32 / 640, 1e-9);  // told by the folder's name
}

TEST(TumReader, PairsTheSmallestDifferencesFirstAndUsesEachImageOnce) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  // 1000.015 is within reach of both depth images; it belongs to the second, which is closer.
  write_text(root / "depth.txt", "1000.000 depth/1000.0000.png\n1000.018 depth/1001.0000.png\n1002.000 depth/1002.0000.png\n");
  write_text(root / "rgb.txt", "1000.015 rgb/1001.0000.png\n1002.019 rgb/1002.0000.png\n1003.0 rgb/1003.0000.png\n");
  write_text(root / "groundtruth.txt", "1000.018 1 2 3 0 0 0 1\n1002.01 4 5 6 0 0 0 1\n");
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 4U);
  EXPECT_EQ(reason(*dataset, 0), "no colour image within 0.02 s");
  EXPECT_EQ(dataset->read(1).frame->color, color_image(1));
  EXPECT_EQ(reason(*dataset, 2), "frame");
  EXPECT_EQ(reason(*dataset, 3), "no depth image within 0.02 s");
}

TEST(TumReader, InterpolatesPosesBetweenCloseNeighboursOnly) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  const double half_turn = std::sqrt(0.5);  // a quarter turn about z, halfway to it a turn of 45 degrees
  write_text(root / "groundtruth.txt",
             fmt::format("999.96 0 0 0 0 0 0 1\n1000.04 1 2 4 0 0 {0} {0}\n"  // 0.08 s apart: in between
                         "1000.99 7 7 7 0 0 0 1\n1001.5 9 9 9 0 0 0 1\n"      // 0.5 s apart: the nearest, 0.01 s away
                         "1002.1 8 8 8 0 0 0 1\n",                            // 0.1 s away: none
                         half_turn));
  const auto dataset = open_recording(root);
  const Pose between = dataset->read(0).frame->world_from_camera;
  EXPECT_TRUE(between.translation().isApprox(Vec3d(0.5, 1, 2), 1e-9));
  EXPECT_NEAR(Eigen::AngleAxisd(between.linear()).angle(), std::numbers::pi / 4, 1e-6);
  EXPECT_TRUE(dataset->read(1).frame->world_from_camera.translation().isApprox(Vec3d(7, 7, 7)));
  EXPECT_EQ(reason(*dataset, 2), "no pose within 0.02 s");
}

TEST(TumReader, SkipsPosesThatAreNotFiniteOrNoRotation) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  write_text(root / "groundtruth.txt",
             "1000 -inf 0 0 0 0 0 1\n1001 0 0 0 nan 0 0 1\n1002 0 0 0 0 0 0 0\n1003 0 0 0 0 0 0 1.01\n");
  const auto dataset = open_recording(root);
  EXPECT_EQ(reason(*dataset, 0), "pose is not finite");
  EXPECT_EQ(reason(*dataset, 1), "pose is not finite");
  EXPECT_EQ(reason(*dataset, 2), "pose is not a rigid transform");
  EXPECT_EQ(reason(*dataset, 3), "frame");
}

TEST(TumReader, NamesFileAndLineOfWhatItCannotRead) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  write_text(root / "groundtruth.txt", "# comment\n1000 1 2 3\n");
  EXPECT_THAT(error_of(root), HasSubstr("groundtruth.txt:2: expected 'time tx ty tz qx qy qz qw', found 4 words"));
  write_text(root / "groundtruth.txt", "1000 1 2 3 0 0 0 one\n");
  EXPECT_THAT(error_of(root), HasSubstr("groundtruth.txt:1: expected a number, found 'one'"));
  write_tum(root);
  write_text(root / "rgb.txt", "nan rgb/1000.0000.png\n");
  EXPECT_THAT(error_of(root), HasSubstr("rgb.txt:1: expected a time stamp"));
  write_text(root / "rgb.txt", "1000.0");  // cut off in a line
  EXPECT_THAT(error_of(root), HasSubstr("rgb.txt:1: expected 'time file', found 1 words"));
  write_tum(root);
  fs::remove(root / "groundtruth.txt");
  EXPECT_THAT(error_of(root), HasSubstr("without groundtruth.txt"));
}

TEST(TumReader, EveryTruncationOfAListIsAnErrorOrSkipsFrames) {
  const fs::path root = fresh_folder("tum");
  for (const char* list : {"rgb.txt", "depth.txt", "groundtruth.txt"}) {
    write_tum(root);
    for (std::uintmax_t bytes = fs::file_size(root / list); bytes-- > 0;) {
      fs::resize_file(root / list, bytes);
      if (error_of(root) != "no error") continue;
      const auto dataset = open_recording(root);
      std::size_t usable = 0;
      for (std::size_t i = 0; i < dataset->size(); ++i) usable += dataset->read(i).frame ? 1 : 0;
      EXPECT_LE(usable, 4U);
    }
  }
}

TEST(TumReader, ManyEqualTimeStampsStayCheap) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  std::string rgb;
  std::string depth;
  for (int i = 0; i < 50000; ++i) {
    rgb += "1000 rgb/1000.0000.png\n";
    depth += "1000 depth/1000.0000.png\n";
  }
  write_text(root / "rgb.txt", rgb);
  write_text(root / "depth.txt", depth);
  EXPECT_GE(open_recording(root)->size(), 50000U);  // all pairs would be 2.5e9
}

TEST(TumReader, ReadsAnAssociationFileWithEitherOrder) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  fs::remove(root / "rgb.txt");
  for (const char* line :
       {"1000 depth/1000.0000.png 1000.01 rgb/1000.0000.png\n", "1000.01 rgb/1000.0000.png 1000 depth/1000.0000.png\n"}) {
    write_text(root / "associations.txt", line);
    const auto dataset = open_recording(root);
    ASSERT_EQ(dataset->size(), 1U);
    expect_frame(dataset->read(0), 0, 5000);
  }
}

TEST(IclReader, TurnsItsUpwardYRoundAndMatchesPosesByNumber) {
  const fs::path root = fresh_folder("living_room_traj0_frei_png");
  write_icl(root);
  const auto dataset = open_recording(root);
  EXPECT_EQ(reason(*dataset, 0), "no pose within 0.02 s");
  for (int i = 1; i < kFrameCount; ++i) expect_frame(dataset->read(static_cast<std::size_t>(i)), i, 5000);
  EXPECT_GT(dataset->read(1).frame->depth_camera.fy, 0);
}

}  // namespace
}  // namespace panoptic::test
