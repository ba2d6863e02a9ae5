// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The same images and poses, stored in each lossless form, are the same frames to the last bit, and so give the same map.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/fresh_folder.h"
#include "tests/io/phone_recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;

// Without a turn, so that no form has to round.
Vec3d position_of(int i) { return {0.5 + 0.25 * i, -1.5, 2.0 + i}; }

void write_plain(const fs::path& root) {
  std::string poses;
  for (int i = 0; i < kFrameCount; ++i) {
    write_color(root / fmt::format("images/{}.png", i), color_image(i, kDepthSize));
    write_depth(root / fmt::format("depth/{}.png", i), raw_depth(i));
    const Vec3d p = position_of(i);
    poses += fmt::format("1 0 0 {} 0 1 0 {} 0 0 1 {} 0 0 0 1\n", p.x(), p.y(), p.z());
  }
  write_text(root / "poses.txt", poses);
  write_text(root / "K.txt", intrinsic_text(depth_camera()));
}

// Writes one form with the images of the plain folder, its poses and its camera, and without confidence.
void write_scene_of_arkit(const fs::path& root) {
  write_arkitscenes(root);
  fs::remove_all(root / "confidence");
  std::string trajectory;
  const Camera c = depth_camera();
  for (int i = 0; i < kFrameCount; ++i) {
    const Vec3d p = -position_of(i);
    trajectory += fmt::format("10.{} 0 0 0 {} {} {}\n", i, p.x(), p.y(), p.z());
    write_text(root / fmt::format("lowres_wide_intrinsics/47333462_10.{}01.pincam", i),
               fmt::format("32 24 {} {} {} {}", c.fx, c.fy, c.cx, c.cy));
  }
  write_text(root / "lowres_wide.traj", trajectory);
}

void write_stray_scan(const fs::path& root) {
  write_stray(root, {.images = false});
  fs::remove_all(root / "confidence");
  std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  for (int i = 0; i < kFrameCount; ++i) {
    const Vec3d p = position_of(i);
    write_color(root / fmt::format("rgb/{:06}.png", i), color_image(i, kDepthSize));
    odometry += fmt::format("{0}, {0:06}, {1}, {2}, {3}, 0, 0, 0, 1\n", i, p.x(), p.y(), p.z());
  }
  write_text(root / "odometry.csv", odometry);
  write_text(root / "camera_matrix.csv", intrinsic_text(depth_camera()));
}

void expect_same(const fs::path& root, const Dataset& plain) {
  SCOPED_TRACE(root.filename().string());
  const auto dataset = open_recording(root);
  ASSERT_EQ(dataset->size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const ReadResult a = plain.read(i);
    const ReadResult b = dataset->read(i);
    ASSERT_TRUE(a.frame) << a.skipped.reason;
    ASSERT_TRUE(b.frame) << b.skipped.reason;
    EXPECT_EQ(a.frame->depth, b.frame->depth);
    EXPECT_EQ(a.frame->color, b.frame->color);
    EXPECT_EQ(a.frame->depth_camera, b.frame->depth_camera);
    EXPECT_EQ(a.frame->color_camera, b.frame->color_camera);
    EXPECT_EQ(a.frame->world_from_camera.matrix(), b.frame->world_from_camera.matrix());
    EXPECT_EQ(a.frame->color_from_depth.matrix(), b.frame->color_from_depth.matrix());
  }
}

TEST(PhoneFrames, AreThoseOfAPlainFolderToTheLastBit) {
  const fs::path folder = fresh_folder("phones");
  write_plain(folder / "plain");
  const auto plain = open_recording(folder / "plain");
  write_scene_of_arkit(folder / "arkitscenes");
  expect_same(folder / "arkitscenes", *plain);
  write_stray_scan(folder / "stray");
  expect_same(folder / "stray", *plain);
}

TEST(PhoneFrames, DoNotHidePlainFoldersWithFilesOfTheSameNames) {
  const fs::path root = fresh_folder("plain");
  write_plain(root);
  fs::rename(root / "images", root / "rgb");
  write_text(root / "metadata.json", "{}");
  write_text(root / "odometry.csv", "0 0 0\n");
  write_text(root / "calib/K.txt", "1 1 0 0\n");
  EXPECT_EQ(open_recording(root)->description(), "plain folder, 4 frames, depth 32x24, colour 32x24");
}

}  // namespace
}  // namespace panoptic::test
