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

std::string reason(const Dataset& dataset, std::size_t position) {
  const ReadResult result = dataset.read(position);
  return result.frame ? "frame" : result.skipped.reason;
}

TEST(TumReader, ReadsFramesWhoseListsDisagreeByMilliseconds) {
  const fs::path root = fresh_folder("rgbd_dataset_freiburg3_desk");
  write_tum(root);
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 4U);
  for (int i = 0; i < kFrameCount; ++i) expect_frame(dataset->read(static_cast<std::size_t>(i)), i, 5000);
  EXPECT_DOUBLE_EQ(dataset->read(1).frame->time_s, 1001);
  EXPECT_NEAR(dataset->read(0).frame->depth_camera.fx, 535.4 * 32 / 640, 1e-9);  // told by the folder's name
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

TEST(TumReader, ReadsListsWithHeadingsAndBackslashes) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  write_text(root / "rgb.txt", "timestamp,filename\n1000.0,rgb\\1000.0000.png\n1001.0,rgb\\1001.0000.png\n");
  write_text(root / "depth.txt", "timestamp,filename\r\n1000.0,depth\\1000.0000.png\r\n1001.0,depth\\1001.0000.png\r\n");
  write_text(root / "groundtruth.txt", "timestamp tx ty tz qx qy qz qw\n1000 1 2 3 0 0 0 1\n1001 4 5 6 0 0 0 1\n");
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 2U);
  EXPECT_EQ(dataset->read(1).frame->color, color_image(1));
  EXPECT_TRUE(dataset->read(1).frame->world_from_camera.translation().isApprox(Vec3d(4, 5, 6)));
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

TEST(TumReader, NamesAPoseInAnAssociationFileAndClocksThatDiffer) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  write_text(root / "groundtruth.txt", "0.5 1 2 3 0 0 0 1\n0.9 1 2 3 0 0 0 1\n");
  EXPECT_THAT(error_of(root),
              HasSubstr("no pose lies within 0.02 s of an image: the time stamps of poses run from 0.500 to 0.900 s, "
                        "those of the depth images from 1000.000 to"));
  write_text(root / "rgb.txt", "5 rgb/1000.0000.png\n");
  EXPECT_THAT(error_of(root), HasSubstr("no colour image lies within 0.02 s of a depth image"));
  fs::remove(root / "rgb.txt");
  write_text(root / "associations.txt", "1000.01 rgb/1000.0000.png 1000 depth/1000.0000.png 1 2 3 0 0 0 1\n");
  EXPECT_THAT(error_of(root), HasSubstr("expected 'time file time file', found 11 words; are the last of them a pose?"));
}

TEST(TumReader, TakesWFirstWhereTheHeadingSaysSo) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  write_text(root / "groundtruth.txt", "# timestamp tx ty tz qw qx qy qz\n1000.0 1 2 3 0 1 0 0\n");
  const auto dataset = open_recording(root);
  EXPECT_TRUE(dataset->pose(0)->linear().isApprox(Vec3d(1, -1, -1).asDiagonal().toDenseMatrix(), 1e-9));
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

TEST(TumReader, ReadsTimeStampsInNanoseconds) {
  const fs::path root = fresh_folder("tum");
  write_tum(root);
  std::string color;
  std::string depth;
  std::string poses;
  for (int i = 0; i < 3; ++i) {
    const std::string ns = fmt::format("{}", 1305031102000000000LL + i * 33000000LL);
    color += fmt::format("{} rgb/100{}.0000.png\n", ns, i);
    depth += fmt::format("{} depth/100{}.0000.png\n", ns, i);
    poses += fmt::format("{} {} 0 0 0 0 0 1\n", ns, i);
  }
  write_text(root / "rgb.txt", color);
  write_text(root / "depth.txt", depth);
  write_text(root / "groundtruth.txt", poses);
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_EQ(reason(*dataset, i), "frame");
    EXPECT_NEAR(dataset->read(i).frame->time_s, 1305031102 + 0.033 * static_cast<double>(i), 1e-5);
    EXPECT_EQ(dataset->read(i).frame->world_from_camera.translation().x(), static_cast<double>(i));
  }
}

// Three pairs a tenth of a second apart, colour this much after depth.
void write_late_colour(const fs::path& root, double late_s) {
  write_tum(root);
  std::string color;
  std::string depth;
  std::string poses;
  for (int i = 0; i < 3; ++i) {
    depth += fmt::format("{:.3f} depth/100{}.0000.png\n", 1000 + 0.1 * i, i);
    color += fmt::format("{:.3f} rgb/100{}.0000.png\n", 1000 + 0.1 * i + late_s, i);
    poses += fmt::format("{:.3f} {} 0 0 0 0 0 1\n", 1000 + 0.1 * i, i);
  }
  write_text(root / "rgb.txt", color);
  write_text(root / "depth.txt", depth);
  write_text(root / "groundtruth.txt", poses);
}

TEST(TumReader, PairsInOrderWhereAConstantOffsetWouldDropFrames) {
  const fs::path root = fresh_folder("tum");
  write_late_colour(root, 0.03);
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(dataset->read(static_cast<std::size_t>(i)).frame->color, color_image(i));
  EXPECT_THAT(dataset->notes().assumed,
              ::testing::Contains("colour images are 30 ms after depth images throughout: paired in their order"));
}

TEST(TumReader, PairsAsFarApartAsTheUserAllows) {
  const fs::path root = fresh_folder("tum");
  write_late_colour(root, 0.015);
  EXPECT_EQ(open_recording(root)->size(), 3U);
  write_text(root / "rgb.txt", "1000.015 rgb/1000.0000.png\n1000.115 rgb/1001.0000.png\n");  // fewer than depth: no order to take
  EXPECT_EQ(open_recording(root)->size(), 3U);
  EXPECT_THROW(open_recording(root, {}, 0.01), Error) << "none has a partner";
  const fs::path plain = fresh_folder("plain");
  write_plain_folder(plain);
  EXPECT_THROW(open_recording(plain, {}, 0.01), Error);
}

TEST(TumReader, SaysWhatItAssumesOfACameraThatItDoesNotKnow) {
  const fs::path own = fresh_folder("my_desk");
  write_tum(own);
  EXPECT_THAT(open_recording(own)->notes().assumed,
              ::testing::ElementsAre(HasSubstr("focal length 26.2"), HasSubstr("5000 raw depth units a metre")));
  const fs::path known = fresh_folder("rgbd_dataset_freiburg3_desk");
  write_tum(known);
  EXPECT_THAT(open_recording(known)->notes().assumed, ::testing::IsEmpty());
}

TEST(TumReader, RemovesTheDistortionOfItsFirstTwoCameras) {
  const fs::path root = fresh_folder("rgbd_dataset_freiburg2_desk");
  write_tum(root);
  const fs::path straight = fresh_folder("straight") / "calibration.toml";
  write_text(straight, "[depth]\ndistortion_model = \"none\"\n");
  const ReadResult removed = open_recording(root)->read(1);
  const ReadResult kept = open_recording(root, straight)->read(1);
  EXPECT_EQ(kept.frame->color, color_image(1));
  EXPECT_NE(removed.frame->color, kept.frame->color);
  EXPECT_NE(removed.frame->depth, kept.frame->depth);
}

}  // namespace
}  // namespace panoptic::test
