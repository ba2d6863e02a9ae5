// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/online.h"

#include <atomic>

#include "panoptic/frame_statistics.h"
#include "panoptic/map.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/online_playback.h"
#include "panoptic/mapping/snapshot.h"
#include "panoptic/profile.h"
#include "panoptic/voxel_map.h"
#include "tests/block_planes.h"
#include "tests/mapping/online_fixture.h"

namespace panoptic {
namespace {

using namespace std::chrono_literals;
using test::expect_accounted;
using test::Networks;
using test::OnlineRun;
using test::Oracle;
using test::Orbit;
using test::orbit_frame;
using test::segmented;

bool same_geometry(const VoxelMap& a, const VoxelMap& b) {
  if (a.block_count() != b.block_count()) return false;
  for (Slot slot = 0; slot < a.block_count(); ++slot) {
    const BlockPlanes left = test::planes_of(a.block(slot));
    const VoxelBlock* right_block = b.find(a.index_of(slot));
    if (right_block == nullptr) return false;
    const BlockPlanes right = test::planes_of(*right_block);
    if (left.distance != right.distance || left.weight != right.weight || left.red != right.red || left.green != right.green ||
        left.blue != right.blue) {
      return false;
    }
  }
  return true;
}

TEST(OnlinePipeline, AtFullSpeedTheGeometryIsThatOfAnOfflineRunBitForBit) {
  const Orbit orbit(40);
  Oracle oracle(2ms);
  OnlineRun run(&oracle);
  play(orbit, {.speed = Playback::kAsFastAsPossible}, run.pipeline);
  const OnlineReport report = run.pipeline.finish();
  EXPECT_EQ(report.failure, nullptr);
  EXPECT_EQ(report.stopped_by, "");
  EXPECT_EQ(report.read, 40U);
  EXPECT_EQ(report.used, 38U);
  EXPECT_EQ(report.skipped, 2U);
  EXPECT_EQ(report.dropped, 0U);
  EXPECT_GT(report.labelled, 0U);
  EXPECT_EQ(report.labelled, run.mapper.labelled());
  expect_accounted(report);

  Mapper offline(test::coarse(), test::test_labels());
  for (std::size_t i = 0; i < orbit.size(); ++i) {
    if (i == 3) continue;  // unreadable in the recording
    const Frame& frame = orbit.frames()[i];
    ASSERT_EQ(offline.add(frame, segmented(frame)).used, is_finite(frame.world_from_camera)) << i;
  }
  offline.finish();
  EXPECT_TRUE(same_geometry(run.mapper.map().voxels, offline.map().voxels));
  EXPECT_EQ(run.mapper.frames().skipped_by_reason(),
            (std::map<std::string, std::uint64_t>{{"pose is not finite", 1}, {"unreadable", 1}}));
}

TEST(OnlinePipeline, WhenEveryFrameIsLabelledBeforeTheNextComesTheMapIsTheOfflineOneBitForBit) {
  Options options = test::coarse();
  options.regularizer.enabled = false;
  Mapper mapper(options, test::test_labels());
  Mapper offline(options, test::test_labels());
  LatestSnapshot latest;
  Oracle oracle;
  OnlinePipeline pipeline({mapper, &oracle, &latest}, {.mesh_every_s = 0.01F});
  for (int i = 0; i < 25; ++i) {
    const Frame frame = orbit_frame(i);
    ASSERT_EQ(offline.add(frame, segmented(frame)), Outcome{});
    pipeline.push_when_free(frame);
    const auto labelled = static_cast<std::uint64_t>(i) + 1;
    while (latest.newest()->run.frames_labelled < labelled) std::this_thread::sleep_for(1ms);
  }
  pipeline.finish();
  offline.finish();
  EXPECT_EQ(mapper.map().voxels.hash(), offline.map().voxels.hash());
}

TEST(OnlinePipeline, TheLastSnapshotShowsTheFinishedMap) {
  Networks networks;
  OnlineRun run(&networks);
  for (int i = 0; i < 12; ++i) run.pipeline.push_when_free(orbit_frame(i));
  const OnlineReport report = run.pipeline.finish();
  const auto snapshot = run.latest.newest();
  EXPECT_TRUE(snapshot->run.finished);
  EXPECT_EQ(snapshot->run.frames_used, 12U);
  EXPECT_EQ(snapshot->run.frames_labelled, report.labelled);
  EXPECT_EQ(snapshot->frame.index, 11);
  EXPECT_EQ(snapshot->frame.labelled_index, 11) << "the newest frame is predicted even if it is the last";
  std::size_t triangles = 0;
  for (const auto& chunk : snapshot->chunks) triangles += chunk.surface->triangles.size();
  EXPECT_EQ(triangles, run.mapper.mesh().triangles.size());
  EXPECT_EQ(report.latency.stages().at("visible").count(), 12U) << "every frame becomes visible once";
  EXPECT_EQ(report.latency.stages().at("fused").count(), 12U);
  for (const char* stage : {"semantic", "instance"}) {
    EXPECT_EQ(run.mapper.profile().stages().at(stage).count(), report.labelled) << stage;
  }
}

// Is at work on its first frame until it is let go.
class Gate final : public Predictor {
 public:
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override {
    entered_ = true;
    while (!open_) std::this_thread::sleep_for(1ms);
    return segmented(frame);
  }
  void wait_until_entered() const {
    while (!entered_) std::this_thread::sleep_for(1ms);
  }
  void open() { open_ = true; }

 private:
  LabelSet labels_ = test::test_labels();
  std::atomic<bool> entered_ = false;
  std::atomic<bool> open_ = false;
};

TEST(OnlinePipeline, ASlowNetworkDropsNoGeometryAndTakesTheNewestFrame) {
  Gate slow;
  OnlineRun run(&slow);
  run.pipeline.push_when_free(orbit_frame(0));
  slow.wait_until_entered();
  for (int i = 1; i < 40; ++i) run.pipeline.push_when_free(orbit_frame(i));
  slow.open();
  const OnlineReport report = run.pipeline.finish();
  EXPECT_EQ(report.used, 40U);
  EXPECT_EQ(report.labelled, 2U) << "the one that it was at work on, and the newest";
  EXPECT_EQ(report.passed_over, 38U);
  EXPECT_EQ(run.latest.newest()->frame.labelled_index, 39);
}

TEST(OnlinePipeline, FramesThatComeWhileFusionIsBehindAreDroppedAndCounted) {
  OnlineRun run;
  int refused = 0;
  const Frame frame = orbit_frame(0);
  for (int i = 0; i < 300; ++i) refused += run.pipeline.push(frame) ? 0 : 1;
  const OnlineReport report = run.pipeline.finish();
  EXPECT_GT(refused, 0);
  EXPECT_EQ(report.dropped, static_cast<std::uint64_t>(refused));
  EXPECT_EQ(report.read, 300U);
  expect_accounted(report);
}

TEST(OnlinePipeline, StopKeepsWhatWasTakenAndTakesNoMore) {
  Networks networks;
  OnlineRun run(&networks);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(run.pipeline.push_when_free(orbit_frame(i)));
  run.pipeline.stop("interrupted");
  run.pipeline.stop("later");
  EXPECT_FALSE(run.pipeline.push(orbit_frame(5)));
  EXPECT_FALSE(run.pipeline.push_when_free(orbit_frame(5)));
  const OnlineReport report = run.pipeline.finish();
  EXPECT_EQ(report.stopped_by, "interrupted");
  EXPECT_EQ(report.used, 5U);
  EXPECT_EQ(run.latest.newest()->run.stopped_by, "interrupted");
  EXPECT_EQ(run.pipeline.finish().used, 5U) << "finish may be called again";
}

TEST(OnlinePipeline, SeveralThreadsMayPush) {
  OnlineRun run;
  std::vector<std::thread> cameras;
  for (int c = 0; c < 3; ++c) {
    cameras.emplace_back([&run, c] {
      for (int i = 0; i < 8; ++i) run.pipeline.push_when_free(orbit_frame(3 * i + c));
    });
  }
  for (std::thread& camera : cameras) camera.join();
  const OnlineReport report = run.pipeline.finish();
  EXPECT_EQ(report.used, 24U);
}

double seconds_of_playing(const Dataset& dataset, double speed) {
  OnlineRun run;
  const Stopwatch stopwatch;
  play(dataset, {.speed = speed}, run.pipeline);
  const double took_s = stopwatch.seconds();
  run.pipeline.finish();
  return took_s;
}

TEST(Playback, FollowsTheTimeStampsAtTheSpeedThatIsAskedFor) {
  const Orbit orbit(16);  // half a second
  for (const double speed : {1.0, 4.0}) {
    const double least_s = 0.5 / speed - 0.001;
    double took_s = seconds_of_playing(orbit, speed);
    EXPECT_GE(took_s, least_s);
    // A busy machine is late, but not every time.
    for (int tries = 0; took_s > least_s + 0.3 && tries < 10; ++tries) took_s = seconds_of_playing(orbit, speed);
    EXPECT_LT(took_s, least_s + 0.3);
    EXPECT_GE(took_s, least_s);
  }
}

TEST(Playback, EndsSoonAfterItIsStoppedInALongPause) {
  class Gap final : public Dataset {
   public:
    std::string description() const override { return "gap"; }
    std::size_t size() const override { return 2; }
    ReadResult read(std::size_t position) const override {
      Frame frame = orbit_frame(static_cast<int>(position));
      frame.time_s = position == 0 ? 0 : 1e300;
      return {std::move(frame), {}};
    }
  };
  OnlineRun run;
  const Stopwatch stopwatch;
  play(Gap(), {}, run.pipeline, [&](std::size_t) {
    if (stopwatch.seconds() > 0.1) run.pipeline.stop("interrupted");
  });
  EXPECT_LT(stopwatch.seconds(), 2);
  EXPECT_EQ(run.pipeline.finish().used, 1U);
}

TEST(OnlinePipeline, RegularizesBesideTheMappingAndCleansUpTheLabels) {
  // One pixel in ten says something else.
  class Noisy final : public Predictor {
   public:
    const LabelSet& labels() const override { return labels_; }
    Segmentation predict(const Frame& frame) override {
      Segmentation s = segmented(frame);
      std::uint32_t state = static_cast<std::uint32_t>(frame.index) * 747796405U + 1;
      for (std::size_t i = 0; i < s.segment_at.size(); ++i) {
        state = state * 1664525U + 1013904223U;
        if (state >> 24 < 26) s.segment_at[i] = static_cast<std::uint16_t>(state >> 8 & 1);
      }
      return s;
    }

   private:
    LabelSet labels_ = test::test_labels();
  };
  Noisy noisy;
  OnlineRun run(&noisy);
  for (int i = 0; i < 30; ++i) {
    run.pipeline.push_when_free(orbit_frame(i));
    std::this_thread::sleep_for(15ms);
  }
  run.pipeline.finish();
  EXPECT_GE(run.mapper.profile().stages().at("regularize beside").count(), 2U);
  // Every label that a voxel holds is an object, and the other way round.
  const std::vector<bool> used = ids_in_use(run.mapper.map().voxels);
  for (std::size_t id = run.mapper.map().labels.first_thing(); id < used.size(); ++id) {
    EXPECT_EQ(used[id], run.mapper.map().objects.find(static_cast<LabelSlot>(id)) != nullptr) << id;
  }
}

}  // namespace
}  // namespace panoptic
