// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/source.h"
#include "tests/fresh_folder.h"
#include "tests/io/phone_recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int kJpeg = 6;  // how far its colours are off

// A file as OpenCV writes it, with lines that are broken. The robot's x looks ahead, y left, z up.
std::string calibration_text(const Camera& c, const std::string& distortion = "0., 0., 0., 0., 0.") {
  return fmt::format(
      "%YAML:1.0\n---\ncamera_name: \"1\"\nimage_width: {}\nimage_height: {}\ncamera_matrix:\n   rows: 3\n   cols: 3\n   data: [ "
      "{}, 0., {}, "
      "0.,\n       {}, {}, 0., 0., 1. ]\ndistortion_coefficients:\n   rows: 1\n   cols: 5\n   data: [ {} ]\ndistortion_model: "
      "plumb_bob\nlocal_transform:\n   rows: 3\n   cols: 4\n   data: [ 0., 0., 1., 0.25, -1., 0., 0., 0.5,\n       0., -1., 0., "
      "1. ]\n",
      c.width, c.height, c.fx, c.cx, c.fy, c.cy, distortion);
}

Pose robot_from_camera() {
  Pose pose = Pose::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  pose.translation() = Vec3d(0.25, 0.5, 1);
  return pose;
}

std::string pose_line(int i, const Pose& pose, bool with_id = true) {
  const Eigen::Quaterniond q(pose.linear());
  const Vec3d t = pose.translation();
  return fmt::format("{:.6f} {} {} {} {} {} {} {}{}\n", 1625000000.25 + i, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w(),
                     with_id ? fmt::format(" {}", 3 * i + 1) : "");
}

// By ids 1, 4, 7, 10, or by stamps.
void write_export(const fs::path& root, const std::string& prefix = "walk_", bool by_stamp = false) {
  std::string camera = "#timestamp x y z qx qy qz qw id\n";
  std::string robot = camera;
  for (int i = 0; i < kFrameCount; ++i) {
    const std::string stem = by_stamp ? fmt::format("{:.6f}", 1625000000.25 + i) : fmt::format("{}", 3 * i + 1);
    write_color(root / (prefix + "rgb") / (stem + ".jpg"), color_image(i));
    write_depth(root / (prefix + "depth") / (stem + ".png"), raw_depth(i));
    write_text(root / (prefix + "calib") / (stem + ".yaml"), calibration_text(stray_camera(i)));
    camera += pose_line(i, Pose(pose_matrix(i)), !by_stamp);
    robot += pose_line(i, Pose(pose_matrix(i)) * robot_from_camera().inverse(), !by_stamp);
  }
  write_text(root / (prefix + "camera_poses.txt"), camera);
  write_text(root / (prefix + "poses.txt"), robot);
}

void expect_frames(const fs::path& root) {
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->description(), "RTAB-Map export, 4 frames, depth 32x24, colour 48x36");
  for (int i = 0; i < kFrameCount; ++i) {
    const ReadResult result = dataset->read(static_cast<std::size_t>(i));
    expect_frame(result, i, 1000, kJpeg);
    ASSERT_TRUE(result.frame);
    EXPECT_NEAR(result.frame->color_camera.fx, stray_camera(i).fx, 1e-9);
    EXPECT_NEAR(result.frame->depth_camera.cx, resized(stray_camera(i), 32, 24).cx, 1e-9);
    EXPECT_DOUBLE_EQ(result.frame->time_s, 1625000000.25 + i);
  }
}

std::string reason(const Dataset& dataset, std::size_t position) {
  const ReadResult result = dataset.read(position);
  return result.frame ? "frame" : result.skipped.reason;
}

TEST(RtabMap, ExportsAreReadByIdAndByStamp) {
  const fs::path ids = fresh_folder("ids");
  write_export(ids);
  expect_frames(ids);
  EXPECT_EQ(open_recording(ids)->read(2).frame->index, 7);
  const fs::path stamps = fresh_folder("stamps");
  write_export(stamps, "walk_", true);
  expect_frames(stamps);
  const fs::path bare = fresh_folder("bare");
  write_export(bare, "");
  expect_frames(bare);
  fs::rename(bare / "camera_poses.txt", bare / "poses.txt");
  expect_frames(bare);
  EXPECT_THAT(open_recording(bare)->notes().assumed,
              ElementsAre(HasSubstr("poses.txt holds the camera's poses, not the robot's")));
}

// From tools/Export/main.cpp of RTAB-Map: the camera's pose is the robot's times local_transform.
TEST(RtabMap, PosesOfTheRobotLeadToItsCamera) {
  const fs::path root = fresh_folder("robot");
  write_export(root);
  fs::remove(root / "walk_camera_poses.txt");
  expect_frames(root);
  write_text(root / "walk_poses.txt", "1 10 20 30 0 0 0 1 1\n");  // looks along x, z is up
  write_depth(root / "walk_depth/1.png", flat_depth(3000));
  const Frame frame = *open_recording(root)->read(0).frame;
  EXPECT_NEAR(seen_at(frame, 15, 12).x(), 13.25, 1e-6);
  EXPECT_LT(seen_at(frame, 31, 12).y(), 20);   // what is right in the image
  EXPECT_GT(seen_at(frame, 15, 1).z(), 31.5);  // what is up in it
}

TEST(RtabMap, CalibrationsOfSomeVersionsHaveTheirMatrixInTheProjection) {
  const fs::path root = fresh_folder("ids");
  write_export(root);
  std::string text = calibration_text(stray_camera());
  const std::string whole = "0.,\n       46.5, 17.75, 0., 0., 1. ]";
  ASSERT_NE(text.find(whole), std::string::npos);
  text.replace(text.find(whole), whole.size(), "0.,\n       0., 46.5, 17.75, 0., 0. ]");
  text += "projection_matrix:\n   rows: 3\n   cols: 4\n   data: [ 45., 0., 23.25, 0., 0., 46.5, 17.75, 0., 0., 0., 1., 0. ]\n";
  write_text(root / "walk_calib/1.yaml", text);
  EXPECT_NEAR(open_recording(root)->read(0).frame->color_camera.fy, 46.5, 1e-9);
}

TEST(RtabMap, ImagesOfALensLoseItsDistortion) {
  const fs::path root = fresh_folder("ids");
  write_export(root);
  for (int i = 0; i < kFrameCount; ++i)
    write_text(root / fmt::format("walk_calib/{}.yaml", 3 * i + 1), calibration_text(stray_camera(), "0.5, 0., 0., 0., 0."));
  const ReadResult result = open_recording(root)->read(1);
  ASSERT_TRUE(result.frame) << result.skipped.reason;
  EXPECT_NE(result.frame->depth(0, 10), static_cast<float>(raw_depth(1)(0, 10)) / 1000);
  write_text(root / "walk_calib/7.yaml", calibration_text(stray_camera()));
  EXPECT_THAT(reason(*open_recording(root), 2), HasSubstr("7.yaml has another lens than the first"));
}

TEST(RtabMap, SayWhatIsMissing) {
  const fs::path root = fresh_folder("ids");
  write_export(root);
  fs::remove(root / "walk_calib/1.yaml");
  fs::remove(root / "walk_depth/4.png");
  write_text(root / "walk_camera_poses.txt",
             pose_line(0, Pose::Identity()) + pose_line(1, Pose::Identity()) + "1 nan 0 0 0 0 0 1 7\n");
  const auto dataset = open_recording(root);
  EXPECT_THAT(reason(*dataset, 0), HasSubstr("no intrinsics that can be used: walk_calib/1.yaml is missing"));
  EXPECT_EQ(reason(*dataset, 1), "depth image missing");
  EXPECT_EQ(reason(*dataset, 2), "pose is not finite");
  EXPECT_EQ(reason(*dataset, 3), "no pose: walk_camera_poses.txt has none of this image");
  write_text(root / "walk_camera_poses.txt", "1 0 0 0 0 0 0 1 99\n");
  EXPECT_THAT(error_of(root), HasSubstr("none of its 1 poses is of an image (the first is 1); export both with rtabmap-export"));
  write_text(root / "walk_camera_poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THAT(error_of(root),
              HasSubstr("12 words, expected 'stamp x y z qx qy qz qw id'; export it in this form: rtabmap-export"));
  fs::remove(root / "walk_camera_poses.txt");
  fs::remove(root / "walk_poses.txt");
  EXPECT_THAT(error_of(root), HasSubstr("RTAB-Map export without poses; export them (rtabmap-export --images_id --poses_camera"));
  EXPECT_EQ(reason(*open_without_poses(root), 2), "frame");
}

TEST(BundleFusion, IsReadWithTheCalibrationOfItsInfo) {
  const fs::path root = fresh_folder("apt0");
  write_scannet_cpp_export(root);
  fs::rename(root / "_info.txt", root / "info.txt");
  for (int i = 0; i < kFrameCount; ++i) {
    fs::remove(root / fmt::format("frame-{:06}.depth.pgm", i));
    write_depth(root / fmt::format("frame-{:06}.depth.png", i), raw_depth(i));
  }
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->description(), "BundleFusion, 4 frames, depth 32x24, colour 48x36");
  for (int i = 0; i < kFrameCount; ++i) expect_frame(dataset->read(static_cast<std::size_t>(i)), i, 1000, kJpeg);
  EXPECT_EQ(dataset->read(0).frame->depth_camera, depth_camera());
  EXPECT_EQ(dataset->read(0).frame->color_camera, color_camera());
  write_text(root / "frame-000002.pose.txt",
             "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  EXPECT_EQ(reason(*dataset, 2), "pose is not finite");
}

}  // namespace
}  // namespace panoptic::test
