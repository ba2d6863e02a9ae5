// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/io/phone_recordings.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"

namespace panoptic::test {
namespace fs = std::filesystem;

Image<std::uint8_t> confidence_image(ImageSize size) {
  Image<std::uint8_t> image(size.width, size.height, 2);
  for (int u = 0; u < size.width; ++u) {
    image(u, 0) = 0;
    image(u, 1) = 1;
  }
  return image;
}

void write_confidence(const fs::path& path, const Image<std::uint8_t>& image) {
  fs::create_directories(path.parent_path());
  write_file(path, encode_png(image));
}

Camera own_camera(int i) {
  Camera camera = depth_camera();
  camera.fx += 0.125 * i;
  camera.cy -= 0.25 * i;
  return camera;
}

Image<std::uint16_t> flat_depth(std::uint16_t value, ImageSize size) { return {size.width, size.height, value}; }

void write_arkitscenes(const fs::path& root) {
  std::string trajectory;
  for (int i = 0; i < kFrameCount; ++i) {
    const std::string stem = fmt::format("47333462_10.{}00", i);
    write_color(root / "lowres_wide" / (stem + ".png"), color_image(i, kDepthSize));
    write_depth(root / "lowres_depth" / (stem + ".png"), raw_depth(i));
    write_confidence(root / "confidence" / (stem + ".png"), confidence_image());
    const Camera camera = own_camera(i);
    write_text(root / "lowres_wide_intrinsics" / fmt::format("47333462_10.{}01.pincam", i),
               fmt::format("{} {} {} {} {} {}", camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy));
    const Pose camera_from_world = Pose(pose_matrix(i)).inverse();
    const Eigen::AngleAxisd turn(camera_from_world.linear());
    const Vec3d rotation = turn.angle() * turn.axis();
    const Vec3d t = camera_from_world.translation();
    trajectory += fmt::format("10.{} {} {} {} {} {} {}\n", i, rotation.x(), rotation.y(), rotation.z(), t.x(), t.y(), t.z());
  }
  write_text(root / "lowres_wide.traj", trajectory);
}

Camera stray_camera(int i) { return {kColorSize.width, kColorSize.height, 45 + 0.25 * i, 46.5, 23.25 - 0.125 * i, 17.75}; }

void write_stray(const fs::path& root, const StrayKind& kind) {
  std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw";
  odometry += kind.own_intrinsics ? ", fx, fy, cx, cy\n" : "\n";
  for (int i = 0; i < kFrameCount; ++i) {
    if (kind.images) write_color(root / "rgb" / fmt::format("{:06}.jpg", i + kind.first_image), color_image(i));
    write_depth(root / "depth" / fmt::format("{:06}.png", i), raw_depth(i));
    write_confidence(root / "confidence" / fmt::format("{:06}.png", i), confidence_image());
    const Pose pose(pose_matrix(i));
    const Eigen::Quaterniond q(pose.linear());
    const Vec3d t = pose.translation();
    odometry +=
        fmt::format("{}, {:06}, {}, {}, {}, {}, {}, {}, {}", 100.5 + i, i, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
    const Camera c = stray_camera(i);
    odometry += kind.own_intrinsics ? fmt::format(", {}, {}, {}, {}\n", c.fx, c.fy, c.cx, c.cy) : "\n";
  }
  write_text(root / "odometry.csv", odometry);
  const Camera c = stray_camera();
  write_text(root / "camera_matrix.csv", fmt::format("{}, 0.0, {}\n0.0, {}, {}\n0.0, 0.0, 1.0", c.fx, c.cx, c.fy, c.cy));
}

Vec3d seen_at(const Frame& frame, int u, int v) {
  return frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
}

void expect_phone_frame(const ReadResult& result, int i, const Camera& camera, int color_tolerance) {
  ASSERT_TRUE(result.frame) << result.skipped.reason;
  const Frame& frame = *result.frame;
  EXPECT_EQ(check(frame).reason, "");
  const auto expect_camera = [](const Camera& actual, const Camera& expected) {
    ASSERT_EQ(actual.width, expected.width);
    ASSERT_EQ(actual.height, expected.height);
    for (const auto number : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy})
      ASSERT_NEAR(actual.*number, expected.*number, 1e-12);
  };
  expect_camera(frame.depth_camera, resized(camera, kDepthSize.width, kDepthSize.height));
  expect_camera(frame.color_camera, resized(camera, frame.color.width(), frame.color.height()));
  EXPECT_LT((frame.world_from_camera.matrix() - pose_matrix(i)).cwiseAbs().maxCoeff(), 1e-12);
  const Image<std::uint16_t> raw = raw_depth(i);
  ASSERT_TRUE(frame.depth.same_size(raw.width(), raw.height()));
  const auto width = static_cast<std::size_t>(raw.width());
  for (std::size_t k = 0; k < width; ++k) ASSERT_EQ(frame.depth[k], 0) << k;
  for (std::size_t k = width; k < raw.size(); ++k) ASSERT_FLOAT_EQ(frame.depth[k], static_cast<float>(raw[k]) / 1000) << k;
  ASSERT_TRUE(frame.depth_weight.same_size(raw.width(), raw.height()));
  for (std::size_t k = width; k < raw.size(); ++k) ASSERT_EQ(frame.depth_weight[k], k / width == 1 ? 0.5F : 1.0F) << k;
  const Image<Rgb> expected = color_image(i, {frame.color.width(), frame.color.height()});
  for (std::size_t k = 0; k < expected.size(); ++k) {
    ASSERT_NEAR(frame.color[k].r, expected[k].r, color_tolerance) << k;
    ASSERT_NEAR(frame.color[k].g, expected[k].g, color_tolerance) << k;
    ASSERT_NEAR(frame.color[k].b, expected[k].b, color_tolerance) << k;
  }
}

}  // namespace panoptic::test
