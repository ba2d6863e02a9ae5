// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Stages that are late and stages that break.
#include <new>

#include "panoptic/frame_statistics.h"
#include "panoptic/mapping/online_playback.h"
#include "tests/mapping/online_fixture.h"

namespace panoptic {
namespace {

using namespace std::chrono_literals;
using test::expect_accounted;
using test::Networks;
using test::OnlineRun;
using test::Orbit;
using test::orbit_frame;
using test::Trouble;

TEST(OnlinePipeline, IsEndedByItsDestructorAtAnyMoment) {
  for (const auto pause : {0ms, 1ms, 7ms, 60ms}) {
    Networks networks;
    Trouble trouble(3, 3000);
    OnlineRun run(&networks, trouble);
    for (int i = 0; i < 6; ++i) run.pipeline.push(orbit_frame(i));
    std::this_thread::sleep_for(pause);
  }
}

TEST(OnlinePipeline, RandomDelaysInEveryStageLoseNothing) {
  Orbit orbit(20);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Networks networks;
    Trouble trouble(seed, seed % 2 == 0 ? 10000 : 500);
    Trouble disk(seed, 3000);
    orbit.trouble = &disk;
    OnlineRun run(&networks, trouble,
                  {.mesh_every_s = 0.05F, .regularize_every_s = 0.1F, .waiting_frames = 1 + static_cast<int>(seed)});
    play(orbit, {.speed = seed < 2 ? 8.0 : Playback::kAsFastAsPossible}, run.pipeline);
    const OnlineReport report = run.pipeline.finish();
    EXPECT_EQ(report.read, 20U);
    EXPECT_EQ(report.failure, nullptr);
    expect_accounted(report);
    EXPECT_EQ(report.used, run.mapper.frames().used());
    EXPECT_EQ(report.skipped, run.mapper.frames().skipped());
    EXPECT_GE(report.labelled + report.passed_over, report.used);
    EXPECT_LE(report.labelled + report.passed_over, report.used + 1) << "the networks may have passed over the unusable frame";
    EXPECT_EQ(run.latest.newest()->run.frames_used, report.used);
  }
}

TEST(OnlinePipeline, AStageThatThrowsAtAnyMomentEndsTheRunWithWhatIsMapped) {
  std::vector<Frame> frames;
  for (int i = 0; i < 40; ++i) frames.push_back(orbit_frame(i));
  for (const char* stage : {"fusion", "networks", "semantic", "instance", "regularizer", "mesher"}) {
    for (const int call : {1, 3}) {
      Networks networks;
      Trouble trouble(static_cast<std::uint64_t>(call), 1000);
      trouble.break_stage(stage, call);
      OnlineRun run(&networks, trouble, {.mesh_every_s = 0.02F, .regularize_every_s = 0.02F, .waiting_frames = 4});
      for (std::size_t i = 0; !run.pipeline.stopped(); ++i) run.pipeline.push_when_free(frames[i % frames.size()]);
      const OnlineReport report = run.pipeline.finish();
      ASSERT_NE(report.failure, nullptr) << stage << call;
      EXPECT_EQ(report.stopped_by, std::string(stage) + " broke");
      expect_accounted(report);
      EXPECT_EQ(run.mapper.frames().used(), report.used);
      EXPECT_TRUE(run.latest.newest()->run.finished);
      EXPECT_EQ(run.latest.newest()->run.stopped_by, report.stopped_by);
      EXPECT_FALSE(run.pipeline.push(orbit_frame(0)));
    }
  }
}

TEST(Playback, EndsWhenTheRunFails) {
  const Orbit orbit(60);
  Networks networks;
  Trouble trouble(1, 0);
  trouble.break_stage("networks", 1);
  OnlineRun run(&networks, trouble);
  play(orbit, {}, run.pipeline);
  EXPECT_LT(run.pipeline.finish().read, 60U);
}

TEST(OnlinePipeline, ADatasetThatThrowsLeavesThePipelineInOrder) {
  Orbit orbit(30);
  Trouble disk(1, 0);
  disk.break_stage("reading", 9);
  orbit.trouble = &disk;
  OnlineRun run;
  EXPECT_THROW(play(orbit, {.speed = Playback::kAsFastAsPossible}, run.pipeline), Error);
  const OnlineReport report = run.pipeline.finish();
  EXPECT_EQ(report.read, 8U);
  EXPECT_EQ(report.used, 6U);
  EXPECT_EQ(report.failure, nullptr);
}

TEST(OnlinePipeline, TheFailureKeepsItsType) {
  class Hungry final : public Predictor {
   public:
    const LabelSet& labels() const override { return labels_; }
    Segmentation predict(const Frame&) override { throw std::bad_alloc(); }

   private:
    LabelSet labels_ = test::test_labels();
  };
  Hungry hungry;
  OnlineRun run(&hungry);
  run.pipeline.push(orbit_frame(0));
  while (!run.pipeline.stopped()) std::this_thread::sleep_for(1ms);
  const OnlineReport report = run.pipeline.finish();
  ASSERT_NE(report.failure, nullptr);
  EXPECT_THROW(std::rethrow_exception(report.failure), std::bad_alloc);
  EXPECT_EQ(report.stopped_by, "out of memory");
}

}  // namespace
}  // namespace panoptic
