// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/camera_tracker.h"

#include <gtest/gtest.h>

#include "panoptic/data/motion.h"
#include "panoptic/error.h"
#include "panoptic/map.h"
#include "panoptic/parallel.h"
#include "tests/tracking/painted_room.h"

namespace panoptic {
namespace {

constexpr int kFrames = 150;  // of the way round

class CameraTracking : public testing::Test {
 protected:
  CameraTracking()
      : mapper_(test::room_mapper()), tracker_({.min_depth_m = 0.1F, .max_depth_m = 8, .start = test::room_pose(0, kFrames)}) {}

  // Tracks a frame whose own pose is of no use, and maps it if the camera is known.
  CameraPose see(const Frame& frame) {
    Frame moved = frame;
    moved.world_from_camera = Pose::Identity();
    const CameraPose pose = tracker_.track(moved, mapper_.map().voxels);
    if (!pose.is_known()) return pose;
    moved.world_from_camera = pose.world_from_camera;
    EXPECT_TRUE(mapper_.add(moved, {}).used);
    tracker_.keep(moved);
    return pose;
  }
  static double off_m(const CameraPose& pose, int n) {
    return difference(pose.world_from_camera, test::room_pose(n, kFrames)).distance_m;
  }

  Mapper mapper_;
  CameraTracker tracker_;
};

TEST_F(CameraTracking, FollowsACameraThroughARoom) {
  EXPECT_EQ(see(test::room_frame(0, kFrames)).state, TrackingState::kBegun);
  double most_m = 0;
  constexpr int kFollowed = 40;
  for (int n = 1; n < kFollowed; ++n) {
    const CameraPose pose = see(test::room_frame(n, kFrames));
    ASSERT_EQ(pose.state, TrackingState::kTracked) << n << ' ' << pose.reason;
    EXPECT_GT(pose.quality, 0.8);
    EXPECT_GT(pose.covariance(0, 0), 0);
    most_m = std::max(most_m, off_m(pose, n));
  }
  EXPECT_LT(most_m, 0.03);  // a voxel
  EXPECT_EQ(tracker_.trajectory().size(), static_cast<std::size_t>(kFollowed));
  EXPECT_GT(tracker_.keyframes(), 2U);
}

TEST_F(CameraTracking, ACoveredLensLosesItAndASeenPlaceFindsItAgain) {
  for (int n = 0; n < 8; ++n) ASSERT_TRUE(see(test::room_frame(n, kFrames)).is_known());
  const std::uint64_t before = mapper_.map().voxels.hash();
  Frame covered = test::room_frame(8, kFrames);
  covered.depth = Image<float>(320, 240, 0.0F);
  covered.color = Image<Rgb>(320, 240, {0, 0, 0});
  const CameraPose lost = tracker_.track(covered, mapper_.map().voxels);
  EXPECT_EQ(lost.state, TrackingState::kLost);
  EXPECT_FALSE(lost.reason.empty());
  EXPECT_FALSE(tracker_.track(covered, mapper_.map().voxels).reason.empty());  // nor the second one's
  EXPECT_EQ(mapper_.map().voxels.hash(), before);
  const CameraPose again = see(test::room_frame(1, kFrames));  // where it was before
  EXPECT_EQ(again.state, TrackingState::kFoundAgain) << again.reason;
  EXPECT_LT(off_m(again, 1), 0.01);
  EXPECT_EQ(see(test::room_frame(2, kFrames)).state, TrackingState::kTracked);
}

// The jump is no motion that goes on.
TEST_F(CameraTracking, GoesOnFromASeenPlaceToWhichItWasCarried) {
  for (int n = 0; n < kFrames / 4; ++n) ASSERT_TRUE(see(test::room_frame(n, kFrames)).is_known());
  EXPECT_EQ(see(test::room_frame(2, kFrames)).state, TrackingState::kFoundAgain);
  for (int n = 3; n < 7; ++n) {
    const CameraPose pose = see(test::room_frame(n, kFrames));
    EXPECT_EQ(pose.state, TrackingState::kTracked) << pose.reason;
    EXPECT_LT(off_m(pose, n), 0.03) << n;  // a voxel
  }
}

TEST_F(CameraTracking, AJumpToAnUnseenPlaceIsNotMapped) {
  for (int n = 0; n < 5; ++n) ASSERT_TRUE(see(test::room_frame(n, kFrames)).is_known());
  Frame elsewhere = test::render(test::bare_wall(), test::room_camera(), test::look_at({0, 0, 1.2}, {0.1, 0, 2}), 5);
  elsewhere.world_from_camera.translation() += Vec3d(7, 3, 5);
  const CameraPose pose = tracker_.track(test::paint(elsewhere), mapper_.map().voxels);
  EXPECT_EQ(pose.state, TrackingState::kLost);
  EXPECT_EQ(tracker_.trajectory().size(), 5U);
}

TEST(CameraTracker, IsTheSameForAnyNumberOfThreads) {
  const auto last_pose = [](int threads) {
    set_thread_count(threads);
    Mapper mapper = test::room_mapper();
    CameraTracker tracker;
    CameraPose pose;
    for (int n = 0; n < 6; ++n) {
      Frame frame = test::room_frame(n, kFrames);
      pose = tracker.track(frame, mapper.map().voxels);
      frame.world_from_camera = pose.world_from_camera;
      EXPECT_TRUE(mapper.add(frame, {}).used);
      tracker.keep(frame);
    }
    return pose.world_from_camera;
  };
  const Pose one = last_pose(1);
  EXPECT_EQ(one.matrix(), last_pose(3).matrix());
  set_thread_count(0);
}

TEST(CameraTracker, RefusesWhatIsNoFrameAndWhatAreNoOptions) {
  const Mapper mapper = test::room_mapper();
  CameraTracker tracker;
  Frame frame = test::room_frame(0, kFrames);
  frame.depth_camera.width = 640;  // its image is 320 wide
  EXPECT_EQ(tracker.track(frame, mapper.map().voxels).state, TrackingState::kLost);
  EXPECT_THROW(CameraTracker({.min_depth_m = 0, .max_depth_m = 8, .start = {}}), Error);
  EXPECT_THROW(CameraTracker({.min_depth_m = 2, .max_depth_m = 1, .start = {}}), Error);
  Pose skewed = Pose::Identity();
  skewed.linear()(0, 1) = 0.5;
  EXPECT_THROW(CameraTracker({.min_depth_m = 0.1F, .max_depth_m = 8, .start = skewed}), Error);
}

TEST(CameraTracker, AFrameThatIsNotKeptIsForgotten) {
  const Mapper mapper = test::room_mapper();
  CameraTracker tracker;
  EXPECT_EQ(tracker.track(test::room_frame(0, kFrames), mapper.map().voxels).state, TrackingState::kBegun);
  EXPECT_EQ(tracker.track(test::room_frame(1, kFrames), mapper.map().voxels).state, TrackingState::kBegun);
  EXPECT_TRUE(tracker.trajectory().empty());
}

TEST(CameraTracker, BeginsLevelWithZUp) {
  CameraTracker tracker;
  const Mapper mapper = test::room_mapper();
  const CameraPose pose = tracker.track(test::room_frame(0, kFrames), mapper.map().voxels);
  ASSERT_EQ(pose.state, TrackingState::kBegun);
  EXPECT_LT((pose.world_from_camera.linear() * Vec3d::UnitY() + Vec3d::UnitZ()).norm(), 1e-12);  // the image's down axis
  EXPECT_LT((pose.world_from_camera.linear() * Vec3d::UnitZ() - Vec3d::UnitY()).norm(), 1e-12);
}

}  // namespace
}  // namespace panoptic
