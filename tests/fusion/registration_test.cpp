// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/registration.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "panoptic/parallel.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

using test::halves;
using test::nearest_of;
using test::plane;
using test::render;
using test::small_camera;
using test::sphere;
using test::Surface;

std::uint32_t packed(Rgb c) { return 0xFF000000U | std::uint32_t{c.r} << 16 | std::uint32_t{c.g} << 8 | c.b; }

// A ball before a wall, and a colour camera that stands 20 cm to the side of the depth camera.
Frame two_camera_frame() {
  const Surface scene = nearest_of({plane(Vec3d::UnitZ(), 3), sphere({0, 0, 1.5}, 0.3)});
  Frame frame = render(scene, small_camera(), Pose::Identity());
  frame.color_camera = {200, 150, 150, 150, 101.3, 77.7};
  Image<Rgb> color(200, 150);
  for (int v = 0; v < 150; ++v) {
    for (int u = 0; u < 200; ++u) color(u, v) = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v), 9};
  }
  frame.color = std::move(color);
  frame.color_from_depth.translation() = Vec3d(0.2, 0.01, 0);
  return frame;
}

struct Naive {
  std::vector<std::uint32_t> color;
  std::vector<std::uint16_t> segment;
};

// The same rule, pixel by pixel, in double.
Naive naive_registration(const Frame& frame, const Segmentation& segmentation) {
  struct Hit {
    int u, v;
    double z;
  };
  std::vector<std::optional<Hit>> hits(frame.depth.size());
  std::map<std::pair<int, int>, double> nearest;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const double z = frame.depth(u, v);
      if (z <= 0) continue;
      const Vec3d p = frame.color_from_depth * back_project(frame.depth_camera, u, v, z);
      const double uc = std::floor(frame.color_camera.fx * p.x() / p.z() + frame.color_camera.cx + 0.5);
      const double vc = std::floor(frame.color_camera.fy * p.y() / p.z() + frame.color_camera.cy + 0.5);
      if (p.z() <= 0 || uc < 0 || vc < 0 || uc >= frame.color.width() || vc >= frame.color.height()) continue;
      const Hit hit{static_cast<int>(uc), static_cast<int>(vc), p.z()};
      hits[static_cast<std::size_t>(v * frame.depth.width() + u)] = hit;
      const auto cell = nearest.try_emplace({hit.u / 2, hit.v / 2}, hit.z).first;
      cell->second = std::min(cell->second, hit.z);
    }
  }
  Naive result{std::vector<std::uint32_t>(hits.size(), 0), std::vector<std::uint16_t>(hits.size(), RegisteredFrame::kNoSegment)};
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i]) continue;
    const double front = nearest.at({hits[i]->u / 2, hits[i]->v / 2});
    if (hits[i]->z > front + std::max(0.03, 0.02 * front)) continue;
    result.color[i] = packed(frame.color(hits[i]->u, hits[i]->v));
    result.segment[i] = segmentation.segment_at(hits[i]->u, hits[i]->v);
  }
  return result;
}

TEST(Registration, OneCameraGivesEachPixelItsOwnColourAndSegment) {
  const Frame frame = render(plane(Vec3d::UnitZ(), 2), small_camera(), Pose::Identity());
  const Segmentation segmentation = halves(frame.color_camera);
  Registration registration({});
  const RegisteredFrame& result = registration.apply(frame, segmentation);
  for (std::size_t i = 0; i < frame.depth.size(); ++i) {
    ASSERT_EQ(result.depth[i], frame.depth[i]);
    ASSERT_EQ(result.color[i], packed(frame.color[i]));
    ASSERT_EQ(result.segment[i], segmentation.segment_at[i]);
  }
}

TEST(Registration, TwoCamerasAgreeWithTheNaiveReference) {
  const Frame frame = two_camera_frame();
  const Segmentation segmentation = halves(frame.color_camera);
  Registration registration({});
  const RegisteredFrame& result = registration.apply(frame, segmentation);
  const Naive naive = naive_registration(frame, segmentation);
  std::size_t different = 0;
  for (std::size_t i = 0; i < frame.depth.size(); ++i) {
    different += result.color[i] != naive.color[i] || result.segment[i] != naive.segment[i] ? 1 : 0;
  }
  EXPECT_LE(different, frame.depth.size() / 1000);  // float and double may round to neighbouring pixels
}

TEST(Registration, WhatTheColourCameraCannotSeeHasNoColourAndNoVote) {
  const Frame frame = two_camera_frame();
  Registration registration({});
  const RegisteredFrame& result = registration.apply(frame, halves(frame.color_camera));
  std::size_t hidden_wall = 0;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const auto i = static_cast<std::size_t>(v * frame.depth.width() + u);
      if (frame.depth(u, v) < 1.25F) {
        EXPECT_NE(result.color[i], 0U) << "the front of the ball is seen";
      } else if (result.color[i] == 0 && frame.depth(u, v) > 2) {
        EXPECT_EQ(result.segment[i], RegisteredFrame::kNoSegment);
        hidden_wall++;
      }
    }
  }
  EXPECT_GT(hidden_wall, 100U) << "the ball hides a part of the wall";
}

TEST(Registration, BadDepthReadingsBecomeNoReading) {
  Frame frame = render(plane(Vec3d::UnitZ(), 2), small_camera(), Pose::Identity());
  Image<float> depth = frame.depth.copied();
  depth[0] = std::numeric_limits<float>::quiet_NaN();
  depth[1] = std::numeric_limits<float>::infinity();
  depth[2] = -1;
  depth[3] = 0.05F;
  depth[4] = 100;
  frame.depth = std::move(depth);
  Registration registration({});
  const RegisteredFrame& result = registration.apply(frame, halves(frame.color_camera));
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(result.depth[i], 0) << i;
    EXPECT_EQ(result.segment[i], RegisteredFrame::kNoSegment) << i;
  }
  EXPECT_EQ(result.depth[5], 2);
}

TEST(Registration, TheExtraPixelHoldsNoReading) {
  const Frame frame = two_camera_frame();
  Registration registration({});
  const RegisteredFrame& result = registration.apply(frame, halves(frame.color_camera));
  ASSERT_EQ(result.depth.size(), result.pixel_count() + 1);
  EXPECT_EQ(result.depth.back(), 0);
  EXPECT_EQ(result.color.back(), 0U);
  EXPECT_EQ(result.segment.back(), RegisteredFrame::kNoSegment);
}

TEST(Registration, AFrameWithoutAPredictionHasNoVotes) {
  const Frame frame = two_camera_frame();
  Registration registration({});
  const RegisteredFrame& result = registration.apply(frame, {});
  for (const std::uint16_t s : result.segment) ASSERT_EQ(s, RegisteredFrame::kNoSegment);
}

TEST(Registration, IsTheSameAtAnyThreadCount) {
  const Frame frame = two_camera_frame();
  const Segmentation segmentation = halves(frame.color_camera);
  Registration one({});
  Registration many({});
  set_thread_count(1);
  const RegisteredFrame a = one.apply(frame, segmentation);
  set_thread_count(4);
  const RegisteredFrame b = many.apply(frame, segmentation);
  set_thread_count(0);
  EXPECT_EQ(a.color, b.color);
  EXPECT_EQ(a.segment, b.segment);
}

}  // namespace
}  // namespace panoptic
