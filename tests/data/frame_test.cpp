// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace panoptic {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr float kNaN32 = std::numeric_limits<float>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Frame good_frame() {
  Frame frame;
  frame.depth_camera = {4, 3, 5, 5, 1.5, 1};
  frame.color_camera = {8, 6, 9, 9, 3.5, 2.5};  // colour may differ in size
  Image<float> depth(4, 3);
  depth(2, 1) = 1.5F;  // one reading is enough
  frame.depth = std::move(depth);
  frame.color = Image<Rgb>(8, 6);
  return frame;
}

std::string reason_after(const std::function<void(Frame&)>& harm) {
  Frame frame = good_frame();
  harm(frame);
  const Outcome outcome = check(frame);
  return outcome.used ? "usable" : outcome.reason;
}

TEST(CheckFrame, AcceptsAGoodFrame) { EXPECT_EQ(check(good_frame()), Outcome{}); }

TEST(CheckFrame, NamesAPoseThatIsNotFiniteInAnyElement) {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        EXPECT_EQ(reason_after([&](Frame& f) { f.world_from_camera.matrix()(row, column) = bad; }), "pose is not finite");
      }
    }
  }
}

TEST(CheckFrame, NamesPosesThatAreNotRigid) {
  EXPECT_EQ(reason_after([](Frame& f) { f.world_from_camera.linear() *= 1.1; }), "pose is not a rigid transform");
  EXPECT_EQ(reason_after([](Frame& f) { f.world_from_camera.linear().setZero(); }), "pose is not a rigid transform");
  EXPECT_EQ(reason_after([](Frame& f) { f.color_from_depth.linear() *= 2; }), "colour camera pose is not a rigid transform");
  EXPECT_EQ(reason_after([](Frame& f) { f.color_from_depth.translation().x() = kNaN; }),
            "colour camera pose is not a rigid transform");
}

TEST(CheckFrame, NamesBadIntrinsics) {
  const std::vector<std::function<void(Camera&)>> harms = {[](Camera& c) { c.fx = 0; },    [](Camera& c) { c.fy = -1; },
                                                           [](Camera& c) { c.fx = kNaN; }, [](Camera& c) { c.fy = kInfinity; },
                                                           [](Camera& c) { c.cx = kNaN; }, [](Camera& c) { c.cy = kInfinity; },
                                                           [](Camera& c) { c.width = 0; }, [](Camera& c) { c.height = -3; }};
  for (const auto& harm : harms) {
    EXPECT_EQ(reason_after([&](Frame& f) { harm(f.depth_camera); }), "depth camera has no valid intrinsics");
    EXPECT_EQ(reason_after([&](Frame& f) { harm(f.color_camera); }), "colour camera has no valid intrinsics");
  }
}

TEST(CheckFrame, NamesIntrinsicsThatAreNotInPixels) {
  const std::vector<std::function<void(Camera&)>> harms = {[](Camera& c) { c.fx = c.fy = 0.3; },    // shares of the image
                                                           [](Camera& c) { c.fx = c.fy = 0.004; },  // metres
                                                           [](Camera& c) { c.fy = 0.09; }, [](Camera& c) { c.cx = 1e6; },
                                                           [](Camera& c) { c.cy = -1e300; }};
  for (const auto& harm : harms) {
    EXPECT_EQ(reason_after([&](Frame& f) { harm(f.depth_camera); }),
              "depth camera would see more than 150 degrees; are its intrinsics in pixels?");
    EXPECT_EQ(reason_after([&](Frame& f) { harm(f.color_camera); }),
              "colour camera would see more than 150 degrees; are its intrinsics in pixels?");
  }
}

TEST(CheckFrame, AcceptsACameraThatSees120Degrees) {
  EXPECT_EQ(reason_after([](Frame& f) { f.depth_camera.fx = f.depth_camera.fy = 2 / std::tan(3.14159 / 3); }), "usable");
}

TEST(CheckFrame, NamesMissingImages) {
  EXPECT_EQ(reason_after([](Frame& f) { f.depth = {}; }), "depth image is missing");
  EXPECT_EQ(reason_after([](Frame& f) { f.color = {}; }), "colour image is missing");
}

TEST(CheckFrame, NamesImagesOfTheWrongSize) {
  EXPECT_EQ(reason_after([](Frame& f) { f.depth = Image<float>(3, 4, 1.0F); }), "depth image has the wrong size");
  EXPECT_EQ(reason_after([](Frame& f) { f.depth = Image<float>(8, 6, 1.0F); }), "depth image has the wrong size");
  EXPECT_EQ(reason_after([](Frame& f) { f.color = Image<Rgb>(4, 3); }), "colour image has the wrong size");
}

TEST(CheckFrame, NamesDepthWeightsThatAreNone) {
  Frame frame = good_frame();
  const Image<float> ones(frame.depth.width(), frame.depth.height(), 1);
  frame.depth_weight = ones;
  EXPECT_EQ(check(frame), Outcome{});
  frame.depth_weight = Image<float>(2, 1, 1);
  EXPECT_EQ(check(frame).reason, "image of depth weights has another size than the depth image");
  for (const float wrong : {0.0F, -1.0F, 1.5F, std::numeric_limits<float>::quiet_NaN()}) {
    Image<float> weights = ones;
    Image<float> depth(ones.width(), ones.height(), 1);
    weights[1] = wrong;
    frame.depth_weight = weights;
    frame.depth = depth;
    EXPECT_EQ(check(frame).reason, "a depth weight is not above 0 and at most 1") << wrong;
    depth[1] = 0;
    frame.depth = depth;
    EXPECT_EQ(check(frame), Outcome{}) << "without a reading there: " << wrong;
  }
}

TEST(CheckFrame, NamesADepthImageWithoutAnyReading) {
  for (const float nothing : {0.0F, -1.0F, kNaN32, std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(reason_after([&](Frame& f) { f.depth = Image<float>(4, 3, nothing); }), "depth image has no reading");
  }
}

}  // namespace
}  // namespace panoptic
