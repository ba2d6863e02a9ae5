// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "panoptic/error.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;

const Camera kCamera{64, 48, 60, 62, 31, 24};
const Distortion kWide = {-0.28, 0.09, 0.001, -0.002, -0.01};

// The formula of OpenCV's documentation (calib3d, "Detailed Description").
Eigen::Vector2d by_the_formula(const Eigen::Vector2d& p, const std::array<double, 8>& c) {
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double r4 = r2 * r2;
  const double r6 = r4 * r2;
  const double radial = (1 + c[0] * r2 + c[1] * r4 + c[4] * r6) / (1 + c[5] * r2 + c[6] * r4 + c[7] * r6);
  return {x * radial + 2 * c[2] * x * y + c[3] * (r2 + 2 * x * x), y * radial + c[2] * (r2 + 2 * y * y) + 2 * c[3] * x * y};
}

TEST(Lens, DistortsAsTheFormulaOfOpenCvSays) {
  const std::array<double, 8> all = {0.26, -0.95, -0.005, 0.003, 1.16, 0.02, -0.01, 0.03};
  for (const std::size_t count : {4U, 5U, 8U}) {
    std::array<double, 8> some{};
    std::copy_n(all.begin(), count, some.begin());
    for (double x = -0.4; x <= 0.4; x += 0.1) {
      const Eigen::Vector2d p(x, 0.3 - x / 2);
      EXPECT_TRUE(
          distorted(p, {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count)}).isApprox(by_the_formula(p, some), 1e-12));
    }
  }
}

// The place without distortion of a pixel of the distorted image, found by fixed-point iteration.
Eigen::Vector2d undistorted_place(int u, int v) {
  const Eigen::Vector2d seen((u - kCamera.cx) / kCamera.fx, (v - kCamera.cy) / kCamera.fy);
  Eigen::Vector2d p = seen;
  for (int i = 0; i < 100; ++i) p += seen - distorted(p, kWide);
  return {kCamera.fx * p.x() + kCamera.cx, kCamera.fy * p.y() + kCamera.cy};
}

TEST(Lens, GivesTheImageOfAPinholeCamera) {
  Image<float> depth(kCamera.width, kCamera.height);
  Image<Rgb> color(kCamera.width, kCamera.height);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const Eigen::Vector2d place = undistorted_place(u, v);
      depth(u, v) = static_cast<float>(place.x() + 100);
      color(u, v) = {static_cast<std::uint8_t>(std::lround(100 + place.x())),
                     static_cast<std::uint8_t>(std::lround(100 + place.y())), 7};
    }
  }
  const LensMap map = lens_map(kCamera, kWide);
  const Image<float> straight = undistorted(depth, map);
  const Image<Rgb> picture = undistorted(color, map);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      ASSERT_NEAR(straight(u, v), u + 100, 0.75);  // the nearest pixel
      ASSERT_NEAR(picture(u, v).r, u + 100, 1);
      ASSERT_NEAR(picture(u, v).g, v + 100, 1);
      ASSERT_EQ(picture(u, v).b, 7);
    }
  }
}

TEST(Lens, LeavesDepthMissingWhereItDidNotLook) {
  const LensMap map = lens_map(kCamera, {0.5, 0, 0, 0});  // the corners lie beyond the image
  EXPECT_EQ(undistorted(Image<float>(64, 48, 2.0F), map)(0, 0), 0);
  EXPECT_EQ(undistorted(Image<float>(64, 48, 2.0F), map)(31, 24), 2);
  EXPECT_EQ(undistorted(Image<Rgb>(64, 48, Rgb{1, 2, 3}), map)(0, 0), (Rgb{1, 2, 3}));
}

TEST(Lens, EndsWhereTheModelTurnsBack) {
  EXPECT_FALSE(std::isnan(distorted({0.5, 0}, {-0.3, 0, 0, 0}).x()));
  EXPECT_TRUE(std::isnan(distorted({1.2, 0}, {-0.3, 0, 0, 0}).x()));  // 1 - 0.9 r^2 < 0 from 1.054 on
}

std::string refusal(const std::string& model, const Distortion& coefficients) {
  try {
    to_distortion(model, coefficients, "here");
  } catch (const Error& e) {
    return e.what();
  }
  return "taken";
}

TEST(Lens, RefusesOtherModelsByTheirName) {
  EXPECT_THAT(refusal("fisheye", {0.1, 0.1, 0.1, 0.1}), HasSubstr("here: the lens model 'fisheye' is not supported"));
  EXPECT_THAT(refusal("opencv", {0.1, 0.1}), HasSubstr("2 numbers"));
  EXPECT_THAT(refusal("opencv", {0.1, 0, 0, 0, 0, 0, 0, 0, 0.1, 0, 0, 0}), HasSubstr("9 numbers"));
  EXPECT_THAT(refusal("", {0.1, 0, 0, std::nan("")}), HasSubstr("not finite"));
  EXPECT_EQ(refusal("plumb_bob", {0.1, 0, 0, 0, 0}), "taken");
  EXPECT_EQ(refusal("rational_polynomial", {0.1, 0, 0, 0, 0, 0, 0, 0.2, 0, 0, 0, 0}), "taken");
}

TEST(Lens, WithoutDistortionHasNoCoefficients) {
  EXPECT_TRUE(to_distortion("plumb_bob", {0, 0, 0, 0, 0}, "here").empty());
  EXPECT_TRUE(to_distortion("none", {0.1, 0, 0, 0}, "here").empty());
}

}  // namespace
}  // namespace panoptic::test
