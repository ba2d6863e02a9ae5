// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A camera that is looked for in the map of an earlier visit.
#include <gtest/gtest.h>

#include "panoptic/camera_tracker.h"
#include "panoptic/data/motion.h"
#include "panoptic/map.h"
#include "panoptic/parallel.h"
#include "tests/tracking/painted_room.h"

namespace panoptic {
namespace {

constexpr int kWay = 150;
constexpr int kMapped = 30;

class RememberedPlaces : public testing::Test {
 protected:
  RememberedPlaces() : mapper_(test::room_mapper()) {
    std::vector<Pose> path;
    std::vector<Frame> frames;
    for (int n = 0; n < kMapped; n += 2) {
      frames.push_back(test::room_frame(n, kWay));
      path.push_back(frames.back().world_from_camera);
      EXPECT_TRUE(mapper_.add(frames.back(), {}).used);
    }
    for (const std::size_t i : keyframes_along(path)) remembered_.push_back(frames[i]);
  }

  CameraTracker tracker() const {
    CameraTracker tracker;
    for (const Frame& frame : remembered_) tracker.remember(frame);
    return tracker;
  }
  CameraPose see(CameraTracker& tracker, Frame frame) {
    frame.world_from_camera = Pose::Identity();
    const CameraPose pose = tracker.track(frame, mapper_.map().voxels);
    if (pose.is_known()) tracker.keep(frame);
    return pose;
  }

  Mapper mapper_;
  std::vector<Frame> remembered_;
};

TEST_F(RememberedPlaces, ACameraIsFoundAndGoesOnInTheirWorld) {
  CameraTracker tracker = this->tracker();
  const std::size_t places = tracker.keyframes();
  EXPECT_EQ(places, remembered_.size());
  EXPECT_GT(places, 1U);
  for (int n = 11; n < 16; ++n) {
    const CameraPose pose = see(tracker, test::room_frame(n, kWay));
    ASSERT_EQ(pose.state, n == 11 ? TrackingState::kFoundAgain : TrackingState::kTracked) << pose.reason;
    EXPECT_LT(difference(pose.world_from_camera, test::room_pose(n, kWay)).distance_m, 0.02) << n;
  }
  EXPECT_EQ(tracker.trajectory().size(), 5U);  // of the further visit alone
  EXPECT_GT(tracker.keyframes(), places);
}

TEST_F(RememberedPlaces, ACameraElsewhereStaysLostUntilItComesThere) {
  CameraTracker tracker = this->tracker();
  Frame elsewhere = test::render(test::bare_wall(), test::room_camera(), test::look_at({0, 0, 1.2}, {0.1, 0, 2}), 5);
  elsewhere.world_from_camera.translation() += Vec3d(7, 3, 5);
  elsewhere = test::paint(elsewhere);
  for (int n = 0; n < 3; ++n) {
    const CameraPose pose = see(tracker, elsewhere);
    EXPECT_EQ(pose.state, TrackingState::kLost);
    EXPECT_EQ(pose.reason, "the place is not recognised");
  }
  EXPECT_TRUE(tracker.trajectory().empty());
  EXPECT_EQ(see(tracker, test::room_frame(20, kWay)).state, TrackingState::kFoundAgain);
}

TEST_F(RememberedPlaces, ThePosesAreTheSameForAnyNumberOfThreads) {
  const auto found = [&](int threads) {
    set_thread_count(threads);
    CameraTracker tracker = this->tracker();
    see(tracker, test::room_frame(7, kWay));
    return see(tracker, test::room_frame(8, kWay)).world_from_camera;
  };
  const Pose one = found(1);
  EXPECT_EQ(one.matrix(), found(3).matrix());
  set_thread_count(0);
}

TEST(KeyframesAlong, AreEveryQuarterOfAMetreAndEveryFifteenDegrees) {
  std::vector<Pose> path(31, Pose::Identity());
  for (std::size_t i = 0; i < path.size(); ++i) path[i].translation().x() = 0.1 * static_cast<double>(i);
  EXPECT_EQ(keyframes_along(path).size(), 11U);
  for (std::size_t i = 0; i < path.size(); ++i) {
    path[i] = Pose::Identity();
    path[i].linear() = Eigen::AngleAxisd(0.1 * static_cast<double>(i), Vec3d::UnitZ()).toRotationMatrix();
  }
  EXPECT_EQ(keyframes_along(path).size(), 11U);
  EXPECT_TRUE(keyframes_along({}).empty());
}

}  // namespace
}  // namespace panoptic
