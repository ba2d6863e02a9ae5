// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/frame_images.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "panoptic/base/bytes.h"
#include "panoptic/map/logged_images.h"

namespace panoptic {
namespace {

// Slopes with noise and holes, in millimetres.
Image<float> sloping_depth(std::mt19937& random, int width, int height, float unit_m = 1 / 1000.F) {
  Image<float> depth(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto units = 1500 + 7 * u + 3 * v + static_cast<int>(random() % 5);
      depth(u, v) = random() % 11 == 0 ? 0 : static_cast<float>(units) * unit_m;
    }
  }
  return depth;
}

Image<Rgb> some_color(std::mt19937& random, int width, int height) {
  Image<Rgb> color(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto gray = static_cast<std::uint8_t>(2 * u + v + static_cast<int>(random() % 7));
      color(u, v) = {gray, static_cast<std::uint8_t>(gray + random() % 9), static_cast<std::uint8_t>(random() % 4 * 85)};
    }
  }
  return color;
}

Frame some_frame(std::mt19937& random) {
  Frame frame;
  frame.depth_camera = {67, 41, 60.5, 61.25, 33, 20};
  frame.color_camera = {90, 50, 80, 80, 45.5, 25};
  frame.color_from_depth.translation() = Vec3d(0.02, -0.1, 1e-9);
  frame.color_from_depth.linear() = Eigen::AngleAxisd(0.03, Vec3d::UnitX()).toRotationMatrix();
  frame.depth = sloping_depth(random, 67, 41);
  frame.color = some_color(random, 90, 50);
  return frame;
}

bool same_bits(const ImageView<float>& a, const ImageView<float>& b) {
  if (!a.same_size(b.width(), b.height())) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::bit_cast<std::uint32_t>(a[i]) != std::bit_cast<std::uint32_t>(b[i])) return false;
  }
  return true;
}

void expect_the_same(const Frame& frame) {
  const auto back = unpack_images(pack_images(frame));
  ASSERT_TRUE(back.has_value());
  EXPECT_TRUE(same_bits(back->depth, frame.depth));
  EXPECT_TRUE(same_bits(back->depth_weight, frame.depth_weight));
  EXPECT_TRUE(back->color == frame.color);
  EXPECT_EQ(back->depth_camera, frame.depth_camera);
  EXPECT_EQ(back->color_camera, frame.color_camera);
  EXPECT_EQ(back->color_from_depth.matrix(), frame.color_from_depth.matrix());
}

TEST(FrameImages, AreTheSameBitForBit) {
  std::mt19937 random(1);
  Frame frame = some_frame(random);
  expect_the_same(frame);
  const std::size_t in_units = pack_images(frame).size();
  for (const float scale : {5000.F, 4000.F, 10000.F, 6553.5F, 1234.F}) {
    frame.depth = sloping_depth(random, 67, 41, 1 / scale);
    expect_the_same(frame);
  }
  EXPECT_GT(pack_images(frame).size(), in_units) << "the last unit is not known: all bits of its numbers are kept";
  frame.depth_weight = Image<float>(67, 41, 0.25F);
  Image<float> odd = sloping_depth(random, 67, 41);
  odd[0] = std::numeric_limits<float>::quiet_NaN();
  odd[1] = -0.0F;
  odd[2] = std::numeric_limits<float>::infinity();
  odd[3] = -3;
  odd[4] = 1e-42F;
  odd[5] = 65.536F;
  frame.depth = odd;
  expect_the_same(frame);
}

TEST(FrameImages, AreReadWhereTheyLie) {
  std::mt19937 random(2);
  Frame frame = some_frame(random);
  const Image<Rgb> color = some_color(random, 90, 50);
  frame.color = SharedImage<Rgb>(ImageView<Rgb>(color.row(49), 90, 50, -std::ptrdiff_t{90} * 3));  // the last row first
  expect_the_same(frame);
  frame.depth_camera.width = frame.color_camera.width = 1;
  frame.depth = Image<float>(1, 41, 2);
  frame.color = some_color(random, 1, 50);
  expect_the_same(frame);
}

TEST(FrameImages, DamagedBytesAreImagesOrNothing) {
  std::mt19937 random(3);
  const Bytes bytes = pack_images(some_frame(random));
  for (std::size_t length = 0; length < bytes.size(); length += 1 + length / 50) {
    EXPECT_FALSE(unpack_images(std::span(bytes).first(length)).has_value());
  }
  for (int round = 0; round < 2000; ++round) {
    Bytes damaged = bytes;
    for (std::size_t n = 1 + random() % 4; n > 0; --n) damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
    const auto back = unpack_images(damaged);
    if (!back) continue;
    EXPECT_TRUE(back->depth.same_size(back->depth_camera.width, back->depth_camera.height));
    EXPECT_TRUE(back->color.same_size(back->color_camera.width, back->color_camera.height));
  }
}

// 256 MB of depth in a file of less than a kilobyte would be taken before anything is seen of them.
TEST(FrameImages, TakeNoMemoryForWhatTheyClaim) {
  std::mt19937 random(4);
  Bytes bytes = pack_images(some_frame(random));
  Bytes sides;
  append_number(sides, std::uint32_t{16384});
  append_number(sides, std::uint32_t{4096});
  std::copy(sides.begin(), sides.end(), bytes.begin());
  bytes.resize(700);
  EXPECT_FALSE(unpack_images(bytes).has_value());
  for (const std::uint32_t side : {0U, 16385U, ~0U}) {
    sides.clear();
    append_number(sides, side);
    std::copy(sides.begin(), sides.end(), bytes.begin());
    EXPECT_FALSE(unpack_images(bytes).has_value());
  }
}

TEST(LoggedImages, GiveTheFrameUpWhenItIsPacked) {
  std::mt19937 random(5);
  const Frame whole = some_frame(random);
  auto owner = std::make_shared<int>();
  const std::weak_ptr<int> lent = owner;
  Frame frame = whole;
  frame.depth = SharedImage<float>(whole.depth, std::move(owner));
  const LoggedImages images(frame);
  frame = {};
  EXPECT_EQ(*images.packed(), pack_images(whole));
  EXPECT_TRUE(lent.expired());
}

}  // namespace
}  // namespace panoptic
