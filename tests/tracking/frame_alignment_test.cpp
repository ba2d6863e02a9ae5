// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/frame_alignment.h"

#include <gtest/gtest.h>

#include "panoptic/map.h"
#include "panoptic/parallel.h"
#include "tests/tracking/painted_room.h"

namespace panoptic {
namespace {

constexpr DepthLimits kRange{0.1F, 8};

class FrameAlignment : public testing::Test {
 protected:
  FrameAlignment() : mapper_(test::room_mapper()) {
    for (int n = 0; n < 4; ++n) EXPECT_TRUE(mapper_.add(test::room_frame(n, 60), {}).used);
  }
  Alignment align_from(const Vector6d& off, const GreyReference* reference = nullptr) const {
    return align({frame_, pyramid_, mapper_.map().voxels, reference, kRange}, frame_.world_from_camera * moved_by(off));
  }

  Mapper mapper_;
  const Frame frame_ = test::room_frame(4, 60);
  const std::vector<GreyLevel> pyramid_ = grey_pyramid(frame_.color, frame_.color_camera);
};

TEST_F(FrameAlignment, FindsThePoseByTheSurfaceAlone) {
  Vector6d off;
  off << 0.03, -0.02, 0.04, 0.02, -0.03, 0.01;
  const Alignment found = align_from(off);
  const PoseDifference d = difference(found.world_from_camera, frame_.world_from_camera);
  EXPECT_LT(d.distance_m, 0.015);  // half a voxel; it began 54 mm off
  EXPECT_LT(d.angle_rad, 0.006);
  EXPECT_GT(found.agreeing_share, 0.95);
  EXPECT_GT(found.surface_share, 0.8);
}

TEST_F(FrameAlignment, FindsThePoseByBrightnessWhereThereIsNoMap) {
  const Frame earlier = test::room_frame(0, 60);
  const GreyReference reference = grey_reference(earlier, grey_pyramid(earlier.color, earlier.color_camera), kRange);
  Vector6d off;
  off << 0.02, 0.01, -0.02, 0.01, 0.01, -0.01;
  const VoxelMap nothing{MapOptions()};
  const Alignment found = align({frame_, pyramid_, nothing, &reference, kRange}, frame_.world_from_camera * moved_by(off));
  const PoseDifference d = difference(found.world_from_camera, frame_.world_from_camera);
  EXPECT_LT(d.distance_m, 0.004);
  EXPECT_LT(d.angle_rad, 0.004);
  EXPECT_GT(found.grey_correlation, 0.9);
  EXPECT_EQ(found.surface_share, 0);
}

TEST_F(FrameAlignment, AChangeOfExposureDoesNotMatter) {
  const Frame earlier = test::room_frame(0, 60);
  GreyReference reference = grey_reference(earlier, grey_pyramid(earlier.color, earlier.color_camera), kRange);
  for (auto& level : reference.levels) {
    for (GreyPoint& point : level) point.grey = 0.7F * point.grey + 15;
  }
  Vector6d off;
  off << 0.02, 0, 0, 0, 0.01, 0;
  const PoseDifference d = difference(align_from(off, &reference).world_from_camera, frame_.world_from_camera);
  EXPECT_LT(d.distance_m, 0.005);
  EXPECT_LT(d.angle_rad, 0.005);
}

TEST_F(FrameAlignment, IsTheSameForAnyNumberOfThreads) {
  Vector6d off;
  off << 0.03, -0.02, 0.04, 0.02, -0.03, 0.01;
  set_thread_count(1);
  const Alignment one = align_from(off);
  set_thread_count(4);
  const Alignment four = align_from(off);
  set_thread_count(0);
  EXPECT_EQ(one.world_from_camera.matrix(), four.world_from_camera.matrix());
}

TEST(FrameAlignmentAtAWall, TheSurfaceDoesNotHoldWhatItCannot) {
  Mapper mapper = test::room_mapper();
  for (int n = 0; n < 3; ++n) {
    const Pose pose = test::look_at({0.1 * n, 0, 0}, {0.1 * n, 0, 2});
    ASSERT_TRUE(mapper.add(test::render(test::bare_wall(), test::room_camera(), pose, n), {}).used);
  }
  const Pose pose = test::look_at({0.1, 0, 0}, {0.1, 0, 2});
  const Frame frame = test::render(test::bare_wall(), test::room_camera(), pose, 3);
  Vector6d off;
  off << 0.05, -0.03, 0.03, 0.01, 0, 0.02;  // along the wall, towards it, and turned
  const std::vector<GreyLevel> pyramid = grey_pyramid(frame.color, frame.color_camera);
  const Pose found = align({frame, pyramid, mapper.map().voxels, nullptr, kRange}, pose * moved_by(off)).world_from_camera;
  const Vec3d moved = found.translation() - pose.translation();
  EXPECT_NEAR(moved.z(), 0, 0.003);    // held by the wall
  EXPECT_NEAR(moved.x(), 0.05, 0.01);  // as it was taken to be
  EXPECT_NEAR(moved.y(), -0.03, 0.01);
}

}  // namespace
}  // namespace panoptic
