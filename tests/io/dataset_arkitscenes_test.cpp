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
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string reason(const Dataset& dataset, std::size_t position) {
  const ReadResult result = dataset.read(position);
  return result.frame ? "frame" : result.skipped.reason;
}

TEST(ArkitScenes, AreReadWithTheIntrinsicsOfEachFrame) {
  const fs::path root = fresh_folder("47333462");
  write_arkitscenes(root);
  const auto dataset = open_recording(root);
  EXPECT_EQ(dataset->description(), "ARKitScenes, 4 frames, depth 32x24, colour 32x24");
  for (int i = 0; i < kFrameCount; ++i) expect_phone_frame(dataset->read(static_cast<std::size_t>(i)), i, own_camera(i));
  EXPECT_DOUBLE_EQ(dataset->read(2).frame->time_s, 10.2);
  EXPECT_THAT(dataset->notes().assumed, ElementsAre());
  // 32 of 766 readings of each frame; the first has two others that are none.
  EXPECT_THAT(dataset->notes().left_out,
              ElementsAre("3.9 % of the depth readings, whose confidence is the lowest (in 4 images looked at)"));
}

// The convention itself, from tenFpsDataLoader.py of ARKitScenes: a line of the trajectory is the camera from the world, pixels
// are those of a camera with x right, y down, z forward. The camera stands at (5, 1, 2) of a world with z up and looks along x:
// the world's x, y, z are then z, -x, -y of the camera, a turn by 120 degrees about (1, -1, 1).
TEST(ArkitScenes, GoFromTheWorldToTheCamera) {
  const fs::path root = fresh_folder("47333462");
  write_arkitscenes(root);
  write_depth(root / "lowres_depth/47333462_10.000.png", flat_depth(3000));
  write_text(root / "lowres_wide.traj", "10.0 1.2091995761561452 -1.2091995761561452 1.2091995761561452 1 2 -5\n");
  const auto dataset = open_recording(root);
  const ReadResult result = dataset->read(0);
  ASSERT_TRUE(result.frame) << result.skipped.reason;
  EXPECT_TRUE(result.frame->world_from_camera.translation().isApprox(Vec3d(5, 1, 2), 1e-12))
      << result.frame->world_from_camera.translation();
  EXPECT_NEAR(seen_at(*result.frame, 15, 12).x(), 8, 1e-6);  // three metres ahead
  EXPECT_LT(seen_at(*result.frame, 31, 12).y(), 0);          // what is right in the image
  EXPECT_GT(seen_at(*result.frame, 15, 1).z(), 2.5);         // what is up in the image
}

TEST(ArkitScenes, GetPosesBetweenThoseOfTheTrajectory) {
  const fs::path root = fresh_folder("47333462");
  write_arkitscenes(root);
  write_text(root / "lowres_wide.traj", "10.05 0 0 0 -1 0 0\n10.15 0 0 0 -2 0 0\n10.5 0 0 0 0 0 0\n");
  const auto dataset = open_recording(root);
  EXPECT_THAT(reason(*dataset, 0), HasSubstr("no pose: none within 0.02 s"));
  EXPECT_NEAR(dataset->read(1).frame->world_from_camera.translation().x(), 1.5, 1e-9);
  EXPECT_THAT(reason(*dataset, 3), HasSubstr("no pose"));  // 0.35 s from one pose to the other
  write_text(root / "lowres_wide.traj", "99.0 0 0 0 0 0 0\n");
  EXPECT_THAT(error_of(root), HasSubstr("none of its 1 poses is of the time of an image (from 10.000 to 10.300 s)"));
  fs::remove(root / "lowres_wide.traj");
  EXPECT_THAT(error_of(root), HasSubstr("ARKitScenes scene without lowres_wide.traj"));
  EXPECT_EQ(reason(*open_without_poses(root), 0), "frame");
}

TEST(ArkitScenes, SkipFramesWithDamagedParts) {
  const fs::path root = fresh_folder("47333462");
  write_arkitscenes(root);
  fs::remove(root / "lowres_depth/47333462_10.000.png");
  write_confidence(root / "confidence/47333462_10.100.png", confidence_image({16, 12}));
  write_text(root / "lowres_wide_intrinsics/47333462_10.201.pincam", "32 24 30 31");
  fs::remove(root / "confidence/47333462_10.300.png");
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), 4U);
  EXPECT_EQ(reason(*dataset, 0), "no depth image within 0.005 s");
  EXPECT_EQ(reason(*dataset, 1), "confidence image is 16x12, and the depth image 32x24");
  EXPECT_THAT(reason(*dataset, 2), HasSubstr("4 numbers, expected width height fx fy cx cy"));
  EXPECT_EQ(reason(*dataset, 3), "confidence image missing");
  write_text(root / "lowres_wide.traj", "10.1 nan 0 0 0 0 0\n");
  EXPECT_EQ(reason(*open_recording(root), 1), "pose is not finite");
}

TEST(ArkitScenes, AreReadFromTheSubsetWithBoxesToo) {
  const fs::path root = fresh_folder("40753679");
  write_arkitscenes(root / "40753679_frames");
  fs::remove_all(root / "40753679_frames/confidence");
  const auto dataset = open_recording(root);
  EXPECT_THAT(dataset->description(), HasSubstr("ARKitScenes, 4 frames"));
  EXPECT_NEAR(dataset->read(1).frame->depth(5, 0), 1.135, 1e-6);
  EXPECT_THAT(dataset->notes().assumed, ElementsAre(HasSubstr("there are no images in confidence/")));
}

TEST(ArkitScenes, TakeOtherIntrinsicsForAllFrames) {
  const fs::path root = fresh_folder("47333462");
  write_arkitscenes(root);
  fs::remove(root / "lowres_wide_intrinsics/47333462_10.001.pincam");
  EXPECT_THAT(reason(*open_recording(root), 0), HasSubstr("no intrinsics within 0.005 s in lowres_wide_intrinsics/"));
  const fs::path file = root / "mine.toml";
  write_text(file, "[depth]\nfx = 33.0\n");
  const auto dataset = open_recording(root, file);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(dataset->read(i).frame->depth_camera.fx, 33.0);
  EXPECT_THAT(dataset->notes().assumed, Contains(HasSubstr("hold for all frames")));
  write_text(file, "[depth]\nscale = 500.0\n");  // says nothing of the cameras
  EXPECT_EQ(open_recording(root, file)->read(2).frame->depth_camera, own_camera(2));
}

TEST(ArkitScenes, SayWhatTheyLack) {
  const fs::path root = fresh_folder("47333462");
  write_arkitscenes(root);
  fs::remove_all(root / "lowres_wide");
  EXPECT_THAT(error_of(root), HasSubstr("nearest is ARKitScenes: it has lowres_depth/, lowres_wide.traj and lacks lowres_wide/"));
  write_color(root / "vga_wide/47333462_90.000.png", color_image(0));
  EXPECT_THAT(error_of(root), HasSubstr("no image in vga_wide/ lies within 0.005 s of one in lowres_depth/ (1 and 4 images"));
}

}  // namespace
}  // namespace panoptic::test
