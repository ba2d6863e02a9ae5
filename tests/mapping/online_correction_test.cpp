// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Online runs whose poses are corrected on the way.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "panoptic/mapfile/log_rows.h"
#include "panoptic/mapping/online_playback.h"
#include "panoptic/mapping/run_recorder.h"
#include "panoptic/mapping/snapshot.h"
#include "panoptic/online.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/drifting.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

using namespace std::chrono_literals;
using namespace test::drifting;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

Segmentation labels_of(int i) { return test::wavering(true_frame(i), 8); }

class KnowsLabels final : public Predictor {
 public:
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override { return labels_of(static_cast<int>(frame.index / 3)); }

 private:
  LabelSet labels_ = test::test_labels();
};

ReadFrame slow_reading(std::chrono::milliseconds takes) {
  return [takes](std::int64_t frame) {
    std::this_thread::sleep_for(takes);
    return read_again(frame);
  };
}

struct FollowingRun {
  explicit FollowingRun(Predictor* predictor = nullptr, ReadFrame read = read_again, RunRecorder* recorder = nullptr) {
    OnlinePipeline::Parts parts{mapper, predictor, &latest};
    parts.read_again = std::move(read);
    parts.recorder = recorder;
    pipeline = std::make_unique<OnlinePipeline>(
        parts, OnlineOptions{.mesh_every_s = 0.05F, .regularize_every_s = 0.1F, .waiting_frames = 8});
  }
  void push(int begin, int end) const {
    for (int i = begin; i < end; ++i) pipeline->push_when_free(drifted_frame(i));
  }
  void wait_until_correcting() const {
    wait_until([&] { return pipeline->is_correcting(); });
  }
  void wait_until(const std::function<bool()>& is_so) const {
    const auto end = Clock::now() + 60s;
    while (!is_so() && !pipeline->stopped() && Clock::now() < end) std::this_thread::sleep_for(1ms);
    EXPECT_TRUE(is_so());
  }

  Mapper mapper{options(), test::test_labels()};
  LatestSnapshot latest;
  std::unique_ptr<OnlinePipeline> pipeline;

  // The regularizer works at moments of its own while a run goes on.
  static Options options() {
    Options options = often();
    options.regularizer.enabled = false;
    return options;
  }
};

TEST(OnlineCorrection, GivesTheMapOfAnOfflineRunBitForBitGeometryAlone) {
  FollowingRun run;
  Mapper offline(FollowingRun::options(), test::test_labels());
  for (const int end : {12, kFrames}) {
    for (int i = end == 12 ? 0 : 12; i < end; ++i) ASSERT_TRUE(offline.add(drifted_frame(i), {}).used);
    offline.update_poses(true_poses(), read_again);
    run.push(end == 12 ? 0 : 12, end);
    ASSERT_TRUE(run.pipeline->update_poses(true_poses()));
  }
  offline.finish();
  const OnlineReport report = run.pipeline->finish();
  EXPECT_EQ(report.stopped_by, "");
  EXPECT_EQ(hashes_of(run.mapper.map()), hashes_of(offline.map()));
  ASSERT_EQ(report.corrections.size(), 2U);
  EXPECT_EQ(report.corrections[0].frames, 11U) << "the first pose is right already";
  EXPECT_EQ(report.corrections[0].unknown, static_cast<std::size_t>(kFrames - 12)) << "frames that are not in the map";
  const auto last = run.latest.newest();
  const Vec3f end_m = true_frame(kFrames - 1).world_from_camera.translation().cast<float>();
  ASSERT_EQ(last->path_m.size(), static_cast<std::size_t>(kFrames));
  EXPECT_TRUE(last->path_m.back().isApprox(end_m)) << "who looks on sees the corrected path";
}

TEST(OnlineCorrection, WithLabelsToo) {
  KnowsLabels labels;
  FollowingRun run(&labels);
  Mapper offline(FollowingRun::options(), test::test_labels());
  for (int i = 0; i < 16; ++i) {
    ASSERT_TRUE(offline.add(drifted_frame(i), labels_of(i)).used);
    run.push(i, i + 1);
    run.wait_until([&] { return run.latest.newest()->run.frames_labelled > static_cast<std::uint64_t>(i); });
    if (i % 10 != 9) continue;
    offline.update_poses(true_poses(i + 1), read_again);
    run.pipeline->update_poses(true_poses(i + 1));
  }
  offline.finish();
  EXPECT_EQ(run.pipeline->finish().corrections.size(), 1U);
  EXPECT_EQ(hashes_of(run.mapper.map()), hashes_of(offline.map()));
}

// Gives the first frame no labels, and those of a later one when it is told to.
class LabelsOneFrameLate final : public Predictor {
 public:
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override {
    if (frame.index == 0 || frame_ >= 0) return {};
    frame_ = frame.index;
    while (!may_go_on_) std::this_thread::sleep_for(1ms);
    return labels_of(static_cast<int>(frame.index / 3));
  }
  std::int64_t frame() const { return frame_; }
  void go_on() { may_go_on_ = true; }

 private:
  LabelSet labels_ = test::test_labels();
  std::atomic<std::int64_t> frame_ = -1;
  std::atomic<bool> may_go_on_ = false;
};

// Saves after every frame.
struct SavedRun {
  SavedRun(Predictor* predictor, ReadFrame read) : following(predictor, std::move(read), &recorder) {}

  std::filesystem::path path = test::fresh_folder() / "map.panoptic";
  Mapper empty{FollowingRun::options(), test::test_labels()};
  Checkpoints checkpoints{{.path = path, .every_s = 0}, identity_online(), empty};
  RunRecorder recorder{&checkpoints};
  FollowingRun following;

  static RunIdentity identity_online() {
    RunIdentity online = identity();
    online.options = FollowingRun::options();
    online.online = true;
    return online;
  }
};

TEST(OnlineCorrection, LateLabelsLeaveTheCorrectedPoseInTheMapFile) {
  LabelsOneFrameLate labels;
  SavedRun saved(&labels, read_again);
  FollowingRun& run = saved.following;
  run.push(0, 1);
  for (int i = 1; i < 12; ++i) run.push(i, i + 1);
  run.wait_until([&] { return labels.frame() >= 0; });
  ASSERT_TRUE(run.pipeline->update_poses(true_poses(12)));
  run.push(12, 14);  // saved with the map anew
  run.wait_until([&] { return run.latest.newest()->run.frames_used >= 14; });
  labels.go_on();
  const OnlineReport report = run.pipeline->finish();
  EXPECT_EQ(report.labelled, 1U);
  saved.checkpoints.finish(run.mapper, true);
  const auto late = static_cast<std::size_t>(labels.frame() / 3);
  const std::vector<FrameRecord> frames = load_frames(saved.path);
  ASSERT_GT(frames.size(), late);
  EXPECT_TRUE(frames[late].labelled);
  const int i = static_cast<int>(late);
  ASSERT_FALSE(drifted_frame(i).world_from_camera.isApprox(true_frame(i).world_from_camera));
  EXPECT_TRUE(frames[late].world_from_camera.value().isApprox(true_frame(i).world_from_camera));
}

TEST(OnlineCorrection, HoldsUpNobodyWhoLooksOn) {
  FollowingRun run(nullptr, slow_reading(20ms));
  run.push(0, kFrames);
  run.pipeline->update_poses(true_poses());
  run.wait_until_correcting();
  const std::uint64_t revision = run.latest.newest()->revision;
  auto longest = Clock::duration::zero();
  std::uint64_t newest = revision;
  while (run.pipeline->is_correcting()) {
    newest = run.latest.newest()->revision;
    const auto before = Clock::now();
    run.pipeline->skip({999, "a probe: it takes the mapper"});
    longest = std::max(longest, Clock::now() - before);
    std::this_thread::sleep_for(2ms);
  }
  const OnlineReport report = run.pipeline->finish();
  ASSERT_EQ(report.corrections.size(), 1U);
  const Correction& correction = report.corrections[0];
  EXPECT_GT(correction.ms, 600) << "20 ms for each of 30 frames";
  EXPECT_LT(std::chrono::duration<double>(longest).count(), test::kSanitized ? correction.ms / 2000 : 0.3);
  EXPECT_LT(correction.pause_ms, correction.ms / 2);
  EXPECT_GE(newest, revision + 2) << "snapshots of the old map";
}

TEST(OnlineCorrection, PlaybackStandsStillAndDropsNothing) {
  FollowingRun run(nullptr, slow_reading(30ms));
  const auto comes = [&](const ReadResult&, std::size_t position) {
    if (position != 15) return;
    run.pipeline->update_poses(true_poses(15));
    run.wait_until_correcting();
  };
  std::vector<std::size_t> done_meanwhile;
  const auto look = [&](std::size_t done) {
    if (run.pipeline->is_correcting()) done_meanwhile.push_back(done);
  };
  const auto start = Clock::now();
  play(Drifting(), {.speed = 4}, *run.pipeline, look, comes);
  const std::chrono::duration<double, std::milli> played = Clock::now() - start;
  const OnlineReport report = run.pipeline->finish();
  ASSERT_EQ(report.corrections.size(), 1U);
  EXPECT_GT(report.corrections[0].ms, 300);
  ASSERT_GE(done_meanwhile.size(), 3U) << "it may be stopped meanwhile";
  EXPECT_EQ(done_meanwhile.front(), done_meanwhile.back());
  EXPECT_GT(played.count(), 29 * 25 + report.corrections[0].ms - 100) << "frames do not come all at once afterwards";
  EXPECT_EQ(report.read, static_cast<std::uint64_t>(kFrames));
  if (test::kSanitized) return;  // fusion may be behind then
  EXPECT_LT(report.dropped, 6U) << "14 frames come afterwards, and only 8 may wait";
}

TEST(OnlineCorrection, StoppedMeanwhileItLeavesASoundMapFile) {
  SavedRun saved(nullptr, slow_reading(10ms));
  FollowingRun& run = saved.following;
  run.push(0, kFrames);
  run.pipeline->update_poses(true_poses());
  run.wait_until_correcting();
  EXPECT_FALSE(load_frames(saved.path).empty()) << "saved before";
  run.pipeline->stop("interrupted");
  EXPECT_FALSE(run.pipeline->update_poses(true_poses())) << "the run is over";
  const OnlineReport report = run.pipeline->finish();
  EXPECT_EQ(report.stopped_by, "interrupted");
  EXPECT_EQ(report.corrections.size(), 1U) << "it was taken, so it is done";
  saved.checkpoints.finish(run.mapper, false);
  EXPECT_EQ(load_map(saved.path).map.voxels.hash(), run.mapper.map().voxels.hash());
  EXPECT_EQ(load_log(saved.path).back().world_from_camera.matrix(), true_frame(kFrames - 1).world_from_camera.matrix());
}

TEST(OnlineCorrection, WhatCannotBeDoneEndsTheRunWithTheOldMap) {
  FollowingRun run(nullptr, [](std::int64_t frame) {
    return frame == 15 ? ReadResult{std::nullopt, {15, "the disk is gone"}} : read_again(frame);
  });
  Mapper offline(FollowingRun::options(), test::test_labels());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(offline.add(drifted_frame(i), {}).used);
  run.push(0, 10);
  run.pipeline->update_poses(true_poses(10));
  const OnlineReport report = run.pipeline->finish();
  EXPECT_THAT(report.stopped_by, HasSubstr("frame 15 cannot be read again: the disk is gone"));
  EXPECT_NE(report.failure, nullptr);
  EXPECT_EQ(hashes_of(run.mapper.map()), hashes_of(offline.map()));

  Mapper mapper(often(), test::test_labels());
  OnlinePipeline blind({mapper}, {});
  EXPECT_THAT(test::error_of([&] { blind.update_poses(true_poses()); }), HasSubstr("Parts::read_again is missing"));
}

}  // namespace
}  // namespace panoptic
