// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map file that is kept of an online run.
#include <gmock/gmock.h>

#include <memory>

#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/online_playback.h"
#include "panoptic/mapping/run_recorder.h"
#include "panoptic/mapping/snapshot.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/online_fixture.h"

namespace panoptic {
namespace {

using namespace std::chrono_literals;
using test::fresh_folder;
using test::Oracle;
using test::Orbit;
using test::orbit_frame;
using testing::HasSubstr;

RunIdentity online_identity() { return {"orbit", "", "", test::coarse(), true}; }

// A mapper, what keeps its map file, and a pipeline around both. Saves after every frame.
struct KeptRun {
  explicit KeptRun(std::filesystem::path file, Predictor* predictor = nullptr) : path(std::move(file)) {
    OnlinePipeline::Parts parts{mapper, predictor, &latest};
    parts.recorder = &recorder;
    pipeline = std::make_unique<OnlinePipeline>(parts, test::OnlineRun::quick());
  }

  std::filesystem::path path;
  Mapper mapper{test::coarse(), test::test_labels()};
  Checkpoints checkpoints{{.path = path, .every_s = 0}, online_identity(), mapper};
  RunRecorder recorder{&checkpoints};
  LatestSnapshot latest;
  std::unique_ptr<OnlinePipeline> pipeline;
};

TEST(OnlineMap, HoldsWhatTheRunMappedAndWhatBecameOfEveryFrame) {
  const Orbit orbit(40);
  Oracle oracle(2ms);
  KeptRun run(fresh_folder() / "map.panoptic", &oracle);
  play(orbit, {.speed = Playback::kAsFastAsPossible}, *run.pipeline);
  const OnlineReport report = run.pipeline->finish();
  run.checkpoints.finish(run.mapper, true);
  const SavedMap saved = load_map(run.path);
  EXPECT_EQ(saved.map.voxels.hash(), run.mapper.map().voxels.hash());
  EXPECT_EQ(saved.map.objects.state(), run.mapper.map().objects.state());
  EXPECT_TRUE(is_complete(saved));
  const std::vector<FrameRecord> frames = load_frames(run.path);
  ASSERT_EQ(frames.size(), report.read);
  std::uint64_t used = 0;
  std::uint64_t labelled = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].position, static_cast<std::int64_t>(i));
    used += frames[i].unused_because.empty() ? 1 : 0;
    labelled += frames[i].labelled ? 1 : 0;
  }
  EXPECT_EQ(used, report.used);
  EXPECT_EQ(labelled, report.labelled) << "corrected when the prediction came";
}

TEST(OnlineMap, AtAnyMomentTheFileIsASoundMapOfEarlierFrames) {
  Oracle oracle;
  KeptRun run(fresh_folder() / "map.panoptic", &oracle);
  std::uint64_t before = 0;
  constexpr int kPatience = 3000;  // frames; on a busy machine a save takes its time
  for (int i = 0; i < 30 || (before == 0 && i < kPatience); ++i) {
    run.pipeline->push_when_free(orbit_frame(i));
    if (i % 5 != 4) continue;
    const SavedMap saved = load_map(run.path);
    EXPECT_FALSE(is_complete(saved));
    const std::uint64_t frames = load_frames(run.path).size();
    EXPECT_GE(frames, before);
    before = frames;
  }
  run.pipeline->finish();
  EXPECT_GT(before, 0U);
}

TEST(OnlineMap, DroppedFramesAreInIt) {
  test::Trouble slow(1, 20000);
  const auto path = fresh_folder() / "map.panoptic";
  Mapper mapper(test::coarse(), test::test_labels());
  Checkpoints checkpoints({.path = path}, online_identity(), mapper);
  RunRecorder recorder(&checkpoints);
  LatestSnapshot latest;
  OnlinePipeline::Parts parts{mapper, nullptr, &latest, 0, std::ref(slow)};
  parts.recorder = &recorder;
  OnlinePipeline pipeline(parts, {.waiting_frames = 1});
  for (int i = 0; i < 30; ++i) pipeline.push(orbit_frame(i));
  const OnlineReport report = pipeline.finish();
  checkpoints.finish(mapper, true);
  ASSERT_GT(report.dropped, 0U);
  const std::vector<FrameRecord> frames = load_frames(path);
  EXPECT_EQ(frames.size(), 30U);
  const auto dropped = [](const FrameRecord& f) { return f.unused_because == "dropped: fusion was behind"; };
  EXPECT_EQ(static_cast<std::uint64_t>(std::count_if(frames.begin(), frames.end(), dropped)), report.dropped);
}

TEST(OnlineMap, CannotBeResumedByAnyRun) {
  const auto path = fresh_folder() / "map.panoptic";
  {
    KeptRun run(path);
    run.pipeline->push_when_free(orbit_frame(0));
    run.pipeline->finish();
    run.checkpoints.finish(run.mapper, false);
  }
  for (const bool online : {false, true}) {
    Mapper mapper(test::coarse(), test::test_labels());
    RunIdentity identity = online_identity();
    identity.online = online;
    EXPECT_THAT(test::error_of([&] { Checkpoints({.path = path, .resume = true}, identity, mapper); }),
                HasSubstr("an online run cannot be resumed"));
  }
}

}  // namespace
}  // namespace panoptic
