// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Online runs that find out where the camera is.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "panoptic/data/motion.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/mapping/run_tracker.h"
#include "panoptic/online.h"
#include "tests/tracking/painted_room.h"

namespace panoptic {
namespace {

using namespace std::chrono_literals;

constexpr int kWayRound = 150;

// A frame whose own pose is of no use.
Frame unposed(int n) {
  Frame frame = test::room_frame(n, kWayRound);
  frame.world_from_camera = Pose::Identity();
  return frame;
}

Frame covered(int n) {
  Frame frame = unposed(n);
  frame.depth = Image<float>(320, 240, 0.2F);
  frame.color = Image<Rgb>(320, 240, {0, 0, 0});
  return frame;
}

// Says of every frame that it is full of table top.
class TableTop final : public Predictor {
 public:
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override {
    newest_ = frame.index;
    if (frame.index < 6) return {};  // labels of the last frame alone
    return {Image<std::uint16_t>(frame.color.width(), frame.color.height(), std::uint16_t{1}), {{ClassId{2}, 1, {}}}};
  }
  std::int64_t newest() const { return newest_; }

 private:
  LabelSet labels_ = test::test_labels();
  std::atomic<std::int64_t> newest_ = -1;
};

class OnlineTracking : public testing::Test {
 protected:
  void start(Predictor* predictor) {
    OnlinePipeline::Parts parts{mapper_, predictor};
    parts.before_work = [this](std::string_view stage) {
      while (stage == "fusion" && held_) std::this_thread::sleep_for(1ms);
    };
    parts.tracker = &tracker_;
    parts.read_again = [](std::int64_t frame) { return ReadResult{unposed(static_cast<int>(frame)), {}}; };
    pipeline_ = std::make_unique<OnlinePipeline>(parts, OnlineOptions{.waiting_frames = 2});
  }
  // Fusion is held up until two frames more were dropped; returns the number of the next.
  int drop_two(int n) {
    held_ = true;
    for (int dropped = 0; dropped < 2; ++n) dropped += pipeline_->push(unposed(n)) ? 0 : 1;
    held_ = false;
    return n;
  }

  std::atomic<bool> held_ = false;
  Mapper mapper_ = test::room_mapper();
  RunTracker tracker_{{.min_depth_m = 0.1F, .max_depth_m = 8, .start = test::room_pose(0, kWayRound)}};
  std::unique_ptr<OnlinePipeline> pipeline_;
};

TEST_F(OnlineTracking, FollowsTheCameraAcrossDroppedFrames) {
  start(nullptr);
  for (int n = 0; n < 24;) {
    if (n == 8 || n == 16) {
      n = drop_two(n);
    } else {
      pipeline_->push_when_free(unposed(n++));
    }
  }
  const OnlineReport report = pipeline_->finish();
  EXPECT_EQ(report.stopped_by, "");
  EXPECT_EQ(report.dropped, 4U);
  EXPECT_EQ(report.used, report.read - 4);
  const TrackingReport tracking = tracker_.report();
  EXPECT_EQ(tracking.tracked, report.used);
  EXPECT_EQ(tracking.lost, 0U);
  const auto& trajectory = mapper_.frames().trajectory();
  ASSERT_EQ(trajectory.size(), report.used);
  for (const TimedPose& pose : trajectory) {
    const Pose truth = test::room_pose(static_cast<int>(pose.frame), kWayRound);
    EXPECT_LT(difference(pose.world_from_camera, truth).distance_m, 0.03) << pose.frame;  // a voxel
  }
}

TEST_F(OnlineTracking, WhereTheCameraIsLostNeitherGeometryNorLabelsAreFused) {
  TableTop network;
  start(&network);
  for (int n = 0; n < 6; ++n) pipeline_->push_when_free(unposed(n));
  pipeline_->push_when_free(covered(6));
  const OnlineReport report = pipeline_->finish();
  EXPECT_EQ(network.newest(), 6) << "the newest frame is predicted even if it is the last";
  EXPECT_EQ(report.failure, nullptr) << report.stopped_by;
  EXPECT_EQ(report.used, 6U);
  EXPECT_EQ(report.skipped, 1U);
  EXPECT_EQ(report.labelled, 0U);
  EXPECT_EQ(mapper_.labelled(), 0U);
  EXPECT_EQ(mapper_.frames().skipped_by_reason().count("the camera is lost"), 1U);
  EXPECT_EQ(tracker_.report().lost, 1U);
}

}  // namespace
}  // namespace panoptic
