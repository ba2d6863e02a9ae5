// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/session/online.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <new>
#include <random>
#include <thread>

#include "panoptic/base/error.h"
#include "panoptic/session/online_playback.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

using namespace std::chrono_literals;
using test::look_at;
using test::render;

Frame orbit_frame(int i) {
  static const test::Surface kScene = test::nearest_of({test::sphere({0, 0, 0}, 0.6), test::plane(Vec3d::UnitY(), 0.6)});
  const double angle = 0.1 * i;
  Frame frame =
      render(kScene, test::small_camera(64, 48), look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), i);
  frame.time_s = 100 + i / 30.0;
  return frame;
}

// The ball is a chair, the floor is floor.
Segmentation segmented(const Frame& frame) {
  Segmentation s{Image<std::uint16_t>(frame.color.width(), frame.color.height()),
                 {{ClassId{3}, 0.9F, {{ClassId{3}, 1.0F}}}, {ClassId{2}, 1, {}}}};
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      s.segment_at(u, v) = p.y() > 0.599 ? 2 : 1;
    }
  }
  return s;
}

// Makes each stage sleep for random times, and one of them throw at its n-th piece of work: what stages do to each other when the
// machine is busy or something breaks.
class Trouble {
 public:
  Trouble(std::uint64_t seed, int longest_us) : seed_(seed), longest_us_(longest_us) {}

  void break_stage(std::string stage, int call) {
    breaks_ = std::move(stage);
    breaks_at_ = call;
  }
  void operator()(std::string_view stage) {
    int call = 0;
    std::uint64_t random = 0;
    {
      const std::lock_guard lock(mutex_);
      call = ++calls_[std::string(stage)];
      random = std::mt19937_64(seed_ + calls_.size() * 1000 + static_cast<std::uint64_t>(call))();
    }
    if (longest_us_ > 0) std::this_thread::sleep_for(random % static_cast<std::uint64_t>(longest_us_) * 1us);
    if (stage == breaks_ && call == breaks_at_) throw Error(std::string(stage) + " broke");
  }
  int calls(const std::string& stage) {
    const std::lock_guard lock(mutex_);
    return calls_[stage];
  }

 private:
  const std::uint64_t seed_;
  const int longest_us_;
  std::string breaks_;
  int breaks_at_ = 0;
  std::mutex mutex_;
  std::map<std::string, int> calls_;
};

// A predictor of two networks that always say the same.
class Networks final : public Predictor {
 public:
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override { return segmented(frame); }
  std::optional<PredictorHalves> halves() override {
    return PredictorHalves{
        [](const Image<Rgb>& color) { return Image<ClassId>(color.width(), color.height(), ClassId{2}); },
        [](const Image<Rgb>& color) {
          const int width = color.width() / 2;
          const int height = color.height() / 2;
          return std::vector<Instance>{
              {{ClassId{3}, 0.9F, {{ClassId{3}, 1.0F}}}, width / 2, height / 2, Image<std::uint8_t>(width, height, 1)}};
        },
        [this](const Image<ClassId>& classes, const std::vector<Instance>& found) { return fuse(classes, found, labels_); }};
  }

 private:
  LabelSet labels_ = test::test_labels();
};

// A predictor in one piece.
class Oracle final : public Predictor {
 public:
  explicit Oracle(std::chrono::microseconds takes = 0us) : takes_(takes) {}
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override {
    std::this_thread::sleep_for(takes_);
    return segmented(frame);
  }

 private:
  std::chrono::microseconds takes_;
  LabelSet labels_ = test::test_labels();
};

// Frames made beforehand. Position 3 cannot be read; position 5 has a pose of NaN.
class Orbit final : public Dataset {
 public:
  explicit Orbit(int frames) {
    for (int i = 0; i < frames; ++i) frames_.push_back(orbit_frame(i));
    if (frames > 5) frames_[5].world_from_camera.translation().x() = std::nan("");
  }
  std::string description() const override { return "orbit"; }
  std::size_t size() const override { return frames_.size(); }
  ReadResult read(std::size_t position) const override {
    if (trouble != nullptr) (*trouble)("reading");
    if (position == 3) return {std::nullopt, {3, "unreadable"}};
    return {frames_[position], {}};
  }
  const std::vector<Frame>& frames() const { return frames_; }

  Trouble* trouble = nullptr;

 private:
  std::vector<Frame> frames_;
};

struct OnlineRun {
  explicit OnlineRun(Predictor* predictor = nullptr, OnlineOptions options = quick())
      : pipeline({session, predictor, latest}, options) {}
  OnlineRun(Predictor* predictor, Trouble& trouble, OnlineOptions options = quick())
      : pipeline({session, predictor, latest, 0, std::ref(trouble)}, options) {}

  // Everything happens often, so that everything meets everything.
  static OnlineOptions quick() { return {.mesh_every_s = 0.05F, .regularize_every_s = 0.1F, .waiting_frames = 4}; }

  Session session{{}, test::test_labels()};
  LatestSnapshot latest;
  OnlinePipeline pipeline;
};

void expect_accounted(const OnlineReport& report) {
  EXPECT_EQ(report.read, report.used + report.skipped + report.dropped + report.lost);
  EXPECT_TRUE(report.failure != nullptr || report.lost == 0) << report.lost;
}

bool same_geometry(const VoxelMap& a, const VoxelMap& b) {
  if (a.block_count() != b.block_count()) return false;
  for (Slot slot = 0; slot < a.block_count(); ++slot) {
    const VoxelBlock& left = a.block(slot);
    const VoxelBlock* right = b.find(a.index_of(slot));
    if (right == nullptr || left.distance != right->distance || left.weight != right->weight || left.red != right->red ||
        left.green != right->green || left.blue != right->blue) {
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
  EXPECT_EQ(report.labelled, run.session.labelled());
  expect_accounted(report);

  Session offline({}, test::test_labels());
  for (std::size_t i = 0; i < orbit.size(); ++i) {
    if (i != 3) offline.add(orbit.frames()[i], segmented(orbit.frames()[i]));
  }
  offline.finish();
  EXPECT_TRUE(same_geometry(run.session.map(), offline.map()));
  EXPECT_EQ(run.session.frames().skipped_by_reason(),
            (std::map<std::string, std::uint64_t>{{"pose is not finite", 1}, {"unreadable", 1}}));
}

TEST(OnlinePipeline, WhenEveryFrameIsLabelledBeforeTheNextComesTheMapIsTheOfflineOneBitForBit) {
  Options options;
  options.regularizer.enabled = false;
  Session session(options, test::test_labels());
  Session offline(options, test::test_labels());
  LatestSnapshot latest;
  Oracle oracle;
  OnlinePipeline pipeline({session, &oracle, latest}, {.mesh_every_s = 0.01F});
  for (int i = 0; i < 25; ++i) {
    const Frame frame = orbit_frame(i);
    offline.add(frame, segmented(frame));
    pipeline.push_when_free(frame);
    const auto labelled = static_cast<std::uint64_t>(i) + 1;
    while (latest.newest()->run.frames_labelled < labelled) std::this_thread::sleep_for(1ms);
  }
  pipeline.finish();
  offline.finish();
  EXPECT_EQ(session.map().hash(), offline.map().hash());
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
  EXPECT_EQ(triangles, run.session.mesh().triangles.size());
  EXPECT_EQ(report.latency.stages().at("visible").count(), 12U) << "every frame becomes visible once";
  EXPECT_EQ(report.latency.stages().at("fused").count(), 12U);
  for (const char* stage : {"semantic", "instance"}) {
    EXPECT_EQ(run.session.profile().stages().at(stage).count(), report.labelled) << stage;
  }
}

TEST(OnlinePipeline, ASlowNetworkDropsNoGeometryAndTakesTheNewestFrame) {
  Oracle slow(30ms);
  OnlineRun run(&slow);
  for (int i = 0; i < 60; ++i) {
    run.pipeline.push_when_free(orbit_frame(i));
    std::this_thread::sleep_for(1ms);
  }
  const OnlineReport report = run.pipeline.finish();
  EXPECT_EQ(report.used, 60U);
  EXPECT_LT(report.labelled, 50U);
  EXPECT_EQ(report.labelled + report.passed_over, 60U) << "every frame was predicted or passed over";
  EXPECT_EQ(run.latest.newest()->frame.labelled_index, 59);
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

TEST(OnlinePipeline, IsEndedByItsDestructorAtAnyMoment) {
  for (const auto pause : {0ms, 1ms, 7ms, 60ms}) {
    Networks networks;
    Trouble trouble(3, 3000);
    OnlineRun run(&networks, trouble);
    for (int i = 0; i < 6; ++i) run.pipeline.push(orbit_frame(i));
    std::this_thread::sleep_for(pause);
  }
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
    EXPECT_EQ(report.used, run.session.frames().used());
    EXPECT_EQ(report.skipped, run.session.frames().skipped());
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
      EXPECT_EQ(run.session.frames().used(), report.used);
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

TEST(Playback, FollowsTheTimeStampsAtTheSpeedThatIsAskedFor) {
  const Orbit orbit(16);  // half a second
  for (const double speed : {1.0, 4.0}) {
    OnlineRun run;
    const Stopwatch stopwatch;
    play(orbit, {.speed = speed}, run.pipeline);
    const double took_s = stopwatch.seconds();
    EXPECT_GE(took_s, 0.5 / speed - 0.001);
    EXPECT_LT(took_s, 0.5 / speed + 0.3);
    run.pipeline.finish();
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
  EXPECT_GE(run.session.profile().stages().at("regularize beside").count(), 2U);
  // What no voxel and no object is can be no label.
  const std::vector<bool> used = ids_in_use(run.session.map());
  for (std::size_t id = run.session.labels().first_thing(); id < used.size(); ++id) {
    EXPECT_EQ(used[id], run.session.objects().find(static_cast<PanopticId>(id)) != nullptr) << id;
  }
}

}  // namespace
}  // namespace panoptic
