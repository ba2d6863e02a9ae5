// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Which frames touch more of the map than a camera can see.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "panoptic/fusion/integrator.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

constexpr float kVoxel_m = 0.024F;
constexpr Camera kOrdinary{640, 480, 525, 525, 319.5, 239.5};

// Readings between these depths, at random.
Frame noise(const Camera& camera, double nearest_m, double farthest_m) {
  std::uint32_t state = 1;
  const auto depth = [&](const Vec3d&, const Vec3d&) {
    state = state * 1664525U + 1013904223U;
    return std::optional(nearest_m + (farthest_m - nearest_m) * (state >> 8) / double{1 << 24});
  };
  return test::render(depth, camera, Pose::Identity());
}

std::string why_too_large(const Frame& frame, float voxel_m, const std::string& method = "projective",
                          float truncation_voxels = 4) {
  VoxelMap map({voxel_m, truncation_voxels});
  Integrator integrator({method}, map);
  Registration registration({0.1F, 1000});
  return integrator.check_extent(frame, registration.apply(frame, {}), map).reason;
}

TEST(Integrator, RefusesDepthThatTouchesMoreBlocksThanAnySurfaceInView) {
  Camera shares = kOrdinary;
  shares.fx = shares.fy = 0.9;
  for (const char* method : {"projective", "raycast"}) {
    EXPECT_THAT(why_too_large(noise(shares, 1, 3), kVoxel_m, method), testing::HasSubstr("intrinsics"));
    EXPECT_THAT(why_too_large(noise(shares, 2.9, 3), kVoxel_m, method), testing::HasSubstr("intrinsics"));
  }
}

TEST(Integrator, TakesWhateverAnOrdinaryOrAWideCameraSees) {
  Camera wide = kOrdinary;
  wide.fx = wide.fy = 320 / std::tan(3.14159 / 3);  // 120 degrees
  for (const Camera& camera : {kOrdinary, wide}) {
    for (const float voxel_m : {0.001F, 0.004F, kVoxel_m, 0.2F}) {
      for (const Frame& frame : {noise(camera, 9.8, 10), noise(camera, 0.1, 8)}) {
        EXPECT_EQ(why_too_large(frame, voxel_m), "") << camera.fx << " " << voxel_m;
      }
    }
    EXPECT_EQ(why_too_large(noise(camera, 0.1, 1000), kVoxel_m), "");
    EXPECT_EQ(why_too_large(noise(camera, 0.1, 4), 0.01F, "projective", 32), "");
  }
}

// The bound holds for all surfaces that cameras of up to 150 degrees see: here a plane, a slanted one and a corridor.
TEST(Integrator, TouchesNoMoreBlocksThanTheBoundAllows) {
  for (const double half_width : {0.3, 1.0, 2.6}) {
    const Camera camera{160, 120, 79.5 / half_width, 79.5 / half_width, 79.5, 59.5};
    for (const test::Surface& surface :
         {test::plane(Vec3d::UnitZ(), 3), test::plane(Vec3d(0.5, 0.3, 0.8).normalized(), 2),
          test::nearest_of({test::plane(Vec3d::UnitX(), 1), test::plane(Vec3d::UnitX(), -1), test::plane(Vec3d::UnitZ(), 8)})}) {
      const Frame frame = test::render(surface, camera, Pose::Identity());
      ASSERT_EQ(check(frame).reason, "");
      VoxelMap map({0.05F, 4});
      Integrator integrator({}, map);
      Registration registration({});
      const RegisteredFrame& registered = registration.apply(frame, {});
      ASSERT_EQ(integrator.check_extent(frame, registered, map).reason, "");
      const std::vector<LabelSlot> labels(registered.segment.size(), LabelSlot::kNoVote);
      integrator.integrate(frame, registered, labels, map);
      const double range = double{registered.farthest_m} / 0.8;
      EXPECT_LE(static_cast<double>(map.block_count()), 4 * 56 * range * range + 1000) << half_width;
    }
  }
}

}  // namespace
}  // namespace panoptic
