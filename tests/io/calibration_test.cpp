// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/error.h"
#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"
#include "tests/places.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;

Calibration known() {
  Calibration calibration;
  calibration.depth = {640, 480, 585, 586, 320, 240};
  return calibration;
}

Calibration read(const std::string& text, Calibration calibration = known()) {
  const std::filesystem::path path = fresh_folder("calibration") / "c.toml";
  write_text(path, text);
  read_calibration(path, calibration);
  return calibration;
}

std::string error_of(const std::string& text, const Calibration& calibration = known()) {
  try {
    read(text, calibration);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(Calibration, KeepsWhatTheFileDoesNotGive) {
  const Calibration nothing = read("");
  EXPECT_EQ(nothing.depth, known().depth);
  EXPECT_FALSE(nothing.color);
  const Calibration scale = read("[depth]\nscale = 5000\n");
  EXPECT_EQ(scale.depth_scale, 5000);
  EXPECT_EQ(scale.depth, known().depth);
  EXPECT_EQ(scale.invalid, known().invalid);
  const Calibration focal = read("[depth]\nfx = 500\n");
  EXPECT_EQ(focal.depth, (Camera{0, 0, 500, 586, 320, 240}));  // new intrinsics belong to the images as they are
}

TEST(Calibration, TheKitchenFileHoldsBothCamerasAndTheWayBetweenThem) {
  Calibration calibration;
  read_calibration(source_folder() / "configs" / "kitchen.toml", calibration);
  EXPECT_EQ(calibration.depth, (Camera{640, 480, 585, 585, 320, 240}));
  EXPECT_EQ(calibration.color, (Camera{640, 480, 525.74, 525.74, 322.97, 236.51}));
  // The projection that the recording's notes give: u = 525.74 (X - 0.0338) / Z + 322.97, v = 525.74 (Y + 0.0058) / Z + 236.51.
  const Vec3d point = calibration.color_from_depth * Vec3d(0.5, -0.25, 2);
  EXPECT_NEAR(525.74 * point.x() / point.z() + 322.97, 525.74 * (0.5 - 0.0338) / 2 + 322.97, 1e-9);
  EXPECT_NEAR(525.74 * point.y() / point.z() + 236.51, 525.74 * (-0.25 + 0.0058) / 2 + 236.51, 1e-9);
}

TEST(Calibration, TakesARotationRowByRow) {
  const Calibration calibration = read("[color_from_depth]\nrotation = [0, -1, 0, 1, 0, 0, 0, 0, 1]\n");
  EXPECT_TRUE((calibration.color_from_depth * Vec3d(1, 0, 0)).isApprox(Vec3d(0, 1, 0)));
}

TEST(Calibration, NamesFileLineAndRemedyOfWhatIsWrong) {
  EXPECT_THAT(error_of("[depth]\nfocal = 5\n"), HasSubstr("c.toml:2: unknown key 'depth.focal'"));
  EXPECT_THAT(error_of("[depth]\nscale = 0\n"), HasSubstr("c.toml:2: 'depth.scale'"));
  EXPECT_THAT(error_of("[depth]\nfx = \"wide\"\n"), HasSubstr("must be a number"));
  EXPECT_THAT(error_of("[depth]\nfx = -1\n"), HasSubstr("depth.fx"));
  EXPECT_THAT(error_of("[depth]\nwidth = 640\n"), HasSubstr("one of width and height"));
  EXPECT_THAT(error_of("[color]\nfx = 500\n"), HasSubstr("[color] needs fx, fy, cx and cy"));
  EXPECT_THAT(error_of("[depth]\nfx = 500\nfy = 500\n", Calibration{}), HasSubstr("[depth] needs fx, fy, cx and cy"));
  EXPECT_THAT(error_of("[color_from_depth]\nrotation = [1, 0]\n"), HasSubstr("has 2 numbers, expected 9"));
  EXPECT_THAT(error_of("[color_from_depth]\nrotation = [1, 0, 0, 0, 1, 0, 0, 0, -1]\n"), HasSubstr("not a rotation"));
  EXPECT_THAT(error_of("[color_from_depth]\ntranslation = [1]\n"), HasSubstr("expected 3"));
  EXPECT_THAT(error_of("[depth\n"), HasSubstr("not valid TOML"));
}

TEST(Calibration, GivesALensItsDistortion) {
  EXPECT_EQ(read("[depth]\ndistortion = [0.1, -0.2, 0, 0]\n").depth_distortion, (Distortion{0.1, -0.2, 0, 0}));
  const Calibration both =
      read("[color]\nfx = 1\nfy = 1\ncx = 1\ncy = 1\ndistortion_model = \"plumb_bob\"\ndistortion = [0.1, -0.2, 0, 0, 0.3]\n");
  EXPECT_EQ(both.color_distortion, (Distortion{0.1, -0.2, 0, 0, 0.3}));
  EXPECT_TRUE(both.depth_distortion.empty());
  EXPECT_THAT(error_of("[color]\ndistortion_model = \"kannala_brandt\"\n"),
              HasSubstr("[color]: the lens model 'kannala_brandt'"));
}

TEST(Calibration, TheLensOfOtherIntrinsicsSaysNothingOfNewOnes) {
  Calibration calibration = known();
  calibration.depth_distortion = {0.1, -0.2, 0, 0};
  EXPECT_EQ(read("[depth]\nscale = 5000\n", calibration).depth_distortion, calibration.depth_distortion);
  EXPECT_TRUE(read("[depth]\nfx = 500\n", calibration).depth_distortion.empty());
  EXPECT_TRUE(read("[depth]\ndistortion_model = \"none\"\n", calibration).depth_distortion.empty());
}

TEST(Calibration, ColourThatIsRegisteredIsDistortedAsDepthIs) {
  Calibration calibration = known();
  calibration.depth_distortion = {0.1, -0.2, 0, 0};
  const Calibration registered = fitted(calibration, {64, 48}, {128, 96}, "here");
  ASSERT_TRUE(registered.depth_lens && registered.color_lens);
  EXPECT_TRUE(registered.color_lens->same_size(128, 96));
  calibration.color = known().depth;
  EXPECT_FALSE(fitted(calibration, {64, 48}, {128, 96}, "here").color_lens);
  EXPECT_FALSE(fitted(known(), {64, 48}, {128, 96}, "here").depth_lens);
}

TEST(Calibration, WhatAFileGivesIsNoLongerAssumed) {
  Calibration calibration = known();
  calibration.camera_is_assumed = calibration.scale_is_assumed = calibration.color_is_assumed = true;
  const Calibration scale = read("[depth]\nscale = 1000\n", calibration);
  EXPECT_TRUE(scale.camera_is_assumed && !scale.scale_is_assumed && scale.color_is_assumed);
  const Calibration camera = read("[depth]\nfx = 585\n", calibration);
  EXPECT_TRUE(!camera.camera_is_assumed && camera.scale_is_assumed && camera.color_is_assumed);
  const Calibration color = read("[color]\nfx = 1\nfy = 1\ncx = 1\ncy = 1\n", calibration);
  EXPECT_TRUE(color.camera_is_assumed && color.scale_is_assumed && !color.color_is_assumed);
}

TEST(Calibration, ScalesIntrinsicsToImagesOfTheSameShape) {
  const Calibration small = fitted(known(), {320, 240}, {160, 120}, "here");
  EXPECT_EQ(small.depth, resized(known().depth, 320, 240));
  EXPECT_EQ(*small.color, resized(known().depth, 160, 120));  // registered: the depth camera at the colour images' size
  EXPECT_THROW(fitted(known(), {320, 200}, {320, 200}, "here"), Error);
  EXPECT_THROW(fitted(Calibration{}, {320, 240}, {320, 240}, "here"), Error);
}

}  // namespace
}  // namespace panoptic::test
