// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A ball that is taken away and put elsewhere while the camera goes round.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/outputs.h"
#include "panoptic/query.h"
#include "panoptic/run_outputs.h"
#include "tests/fresh_folder.h"
#include "tests/fusion/space_scenes.h"

namespace panoptic {
namespace {

using test::fresh_folder;

constexpr int kMoved = 60;  // the frame from which on it is elsewhere
constexpr int kFrames = 150;
constexpr double kRadius_m = 0.3;
const Vec3d kBefore(-0.8, 0.9, 0.3);
const Vec3d kAfter(0.9, 0.9, 0.3);

Frame view_of(const test::Surface& scene, int i) {
  const double angle = 0.1 * i;
  const Vec3d eye(0.9 * std::sin(angle), -0.6 + 0.2 * std::cos(1.7 * angle), -1.9);
  Frame frame = test::render(scene, test::small_camera(), test::look_at(eye, {0.3 * std::cos(angle), 0.7, 0.6}), i);
  frame.time_s = i / 30.0;
  return frame;
}

Frame frame_at(int i) { return view_of(test::room({test::sphere(i < kMoved ? kBefore : kAfter, kRadius_m)}), i); }

// Perfect masks: the ball is a chair, all else is wall.
Segmentation segmentation_of(const Frame& frame) {
  const ClassId chair{3};
  Segmentation s{Image<std::uint16_t>(frame.color.width(), frame.color.height()),
                 {{chair, 0.9F, {{chair, 1.0F}}}, {ClassId{1}, 1, {}}}};
  const Vec3d ball = frame.index < kMoved ? kBefore : kAfter;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      s.segment_at(u, v) = (p - ball).norm() < kRadius_m + 0.01 ? 1 : 2;
    }
  }
  return s;
}

Options options() {
  Options options;
  options.map.voxel_size_m = 0.04F;
  options.regularizer.enabled = false;
  return options;
}

void add(int begin, int end, Mapper& mapper, Checkpoints* checkpoints = nullptr) {
  for (int i = begin; i < end; ++i) {
    const Frame frame = frame_at(i);
    ASSERT_TRUE(mapper.add(frame, segmentation_of(frame)).used);
    if (checkpoints == nullptr) continue;
    checkpoints->note({.frame = i, .time_s = frame.time_s, .world_from_camera = frame.world_from_camera, .labelled = true});
  }
}

std::string objects_text(const Mapper& mapper, const Mesh& mesh) { return objects_json(mapper, mesh).dump(); }

TEST(Changes, ABallThatWasPutElsewhereIsKnownToHaveMoved) {
  Mapper mapper(options(), test::test_labels());
  add(0, kFrames, mapper);
  mapper.finish();
  const ObjectHistory& history = mapper.map().history;
  ASSERT_EQ(history.past.size(), 1U);
  ASSERT_EQ(history.arrivals.size(), 1U);
  const auto& [id, arrival] = *history.arrivals.begin();
  EXPECT_EQ(arrival.moved_from, history.past[0].id);
  EXPECT_EQ(history.past[0].moved_to, id);
  EXPECT_LT((history.past[0].box.center_m - kBefore).norm(), 0.2);
  EXPECT_GE(history.past[0].gone_frame, kMoved);
  const Json objects = objects_json(mapper, mapper.mesh())["objects"];
  ASSERT_EQ(objects.size(), 2U);
  for (const Json& object : objects) {
    const bool is_past = object["vertices"] == 0;
    EXPECT_EQ(object["state"], is_past ? "moved" : "present");
    EXPECT_EQ(object["appeared"], !is_past);
    EXPECT_EQ(object["gone_time"].is_null(), !is_past);
  }
}

// Callers may not know the times of frames: then they are taken to be 1/30 s apart.
TEST(Changes, AreTheSameOfFramesWithoutTimes) {
  Mapper timed(options(), test::test_labels());
  Mapper timeless(options(), test::test_labels());
  for (int i = 0; i < kFrames; ++i) {
    Frame frame = frame_at(i);
    ASSERT_TRUE(timed.add(frame, segmentation_of(frame)).used);
    frame.time_s = 0;
    ASSERT_TRUE(timeless.add(frame, segmentation_of(frame)).used);
  }
  timed.finish();
  timeless.finish();
  EXPECT_EQ(timeless.map().voxels.hash(), timed.map().voxels.hash());
  EXPECT_EQ(timeless.map().history.arrivals.size(), 1U);
}

// Whoever sits there from the first frame on was never seen to move, and no network knows them for a person: they are furniture,
// and gone when they leave, with their surface.
TEST(Changes, WhoSitsThereFromTheFirstFrameAndLeavesIsGone) {
  Mapper mapper(options(), test::test_labels());
  const auto near_place = [&] {  // and not at the floor, on which the ball lies
    std::size_t vertices = 0;
    for (const MeshVertex& vertex : mapper.mesh().vertices) {
      const Vec3d at = vertex.position.cast<double>();
      vertices += (at - kBefore).norm() < kRadius_m + 0.05 && at.y() < 1.15 ? 1 : 0;
    }
    return vertices;
  };
  for (int i = 0; i < kFrames; ++i) {
    if (i == kMoved) {
      EXPECT_GT(near_place(), 200U);
    }
    const Frame frame = i < kMoved ? frame_at(i) : view_of(test::room(), i);
    ASSERT_TRUE(mapper.add(frame, segmentation_of(frame)).used);
  }
  mapper.finish();
  ASSERT_EQ(mapper.map().history.past.size(), 1U);
  EXPECT_TRUE(mapper.map().history.arrivals.empty());
  EXPECT_EQ(near_place(), 0U);
  EXPECT_TRUE(mapper.parts().moving_tracks().tracks().empty());
}

TEST(Changes, AreThereOnlyWhereTheyAreAskedFor) {
  Options off = options();
  off.moving = {.classes = false, .points = false, .objects = false};
  Mapper mapper(off, test::test_labels());
  add(0, kFrames, mapper);
  mapper.finish();
  EXPECT_TRUE(mapper.map().history.past.empty());
  EXPECT_TRUE(mapper.map().history.arrivals.empty());
  EXPECT_TRUE(mapper.parts().moving_tracks().tracks().empty());
}

TEST(Changes, AreTheSameAfterAnInterruptionAndInTheMapFile) {
  Mapper whole(options(), test::test_labels());
  add(0, kFrames, whole);
  whole.finish();

  const auto path = fresh_folder() / "map.panoptic";
  const RunIdentity run{"somewhere", "", "", options()};
  CheckpointSettings settings{.path = path, .resume = true};
  settings.every_s = 1e6;
  for (const int end : {70, 100}) {
    Mapper mapper(options(), test::test_labels());
    Checkpoints checkpoints(settings, run, mapper);
    add(end == 70 ? 0 : 70, end, mapper, &checkpoints);
    checkpoints.finish(mapper, false);
  }
  Mapper mapper(options(), test::test_labels());
  {
    Checkpoints checkpoints(settings, run, mapper);
    add(100, kFrames, mapper, &checkpoints);
    mapper.finish();
    checkpoints.finish(mapper, true);
  }
  EXPECT_EQ(mapper.map().voxels.hash(), whole.map().voxels.hash());
  EXPECT_EQ(objects_text(mapper, mapper.mesh()), objects_text(whole, whole.mesh()));
  EXPECT_EQ(mapper.parts().moving_tracks().tracks(), whole.parts().moving_tracks().tracks());

  const SavedMap saved = load_map(path);
  const std::vector<ObjectSpan> spans = object_spans(saved.map, load_frames(path));
  ASSERT_EQ(spans.size(), 2U);
  EXPECT_EQ(present_at(spans, 1).size(), 1U);
  EXPECT_EQ(present_at(spans, 1)[0].id, spans[0].id);
  EXPECT_EQ(present_at(spans, 4.9).back().moved_from, spans[0].id);
  EXPECT_EQ(changed_since(spans, 1).size(), 2U);
  EXPECT_TRUE(changed_since(spans, 5).empty());
}

// An object that is found to be gone at the very end is cleared after the last checkpoint.
TEST(Changes, FoundAtTheEndAreInAFileThatWasSavedRightBefore) {
  const auto path = fresh_folder() / "map.panoptic";
  Options late = options();
  late.objects.every_frames = 1000;
  const RunIdentity run{"somewhere", "", "", late};
  CheckpointSettings settings{.path = path, .resume = false};
  settings.every_s = 0;
  Mapper mapper(late, test::test_labels());
  Checkpoints checkpoints(settings, run, mapper);
  add(0, kFrames, mapper, &checkpoints);
  checkpoints.after_frame(mapper);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  checkpoints.after_frame(mapper);  // takes note that the first one is written
  const std::uint64_t before = mapper.map().voxels.hash();
  mapper.finish();
  ASSERT_NE(mapper.map().voxels.hash(), before);
  checkpoints.finish(mapper, true);
  EXPECT_EQ(load_map(path).map.voxels.hash(), mapper.map().voxels.hash());
}

// A correction that moves nothing much finds what the run found, and when.
TEST(Changes, AreFoundAgainWhenPosesAreCorrected) {
  Options logged = options();
  logged.map.log = "reference";
  Mapper mapper(logged, test::test_labels());
  add(0, kFrames, mapper);
  mapper.finish();
  const ObjectHistory before = mapper.map().history;
  ASSERT_EQ(before.past.size(), 1U);
  Pose pose = frame_at(3).world_from_camera;
  pose.translation().x() += 0.01;
  const std::vector<PoseUpdate> poses = {{.frame = 3, .world_from_camera = pose}};
  mapper.update_poses(poses, [](std::int64_t frame) { return ReadResult{frame_at(static_cast<int>(frame)), {}}; });
  const ObjectHistory& after = mapper.map().history;
  ASSERT_EQ(after.past.size(), 1U);
  EXPECT_EQ(after.past[0].id, before.past[0].id);
  EXPECT_NEAR(static_cast<double>(after.past[0].gone_frame), static_cast<double>(before.past[0].gone_frame), 5);
  EXPECT_EQ(after.past[0].moved_to, before.past[0].moved_to);
}

}  // namespace
}  // namespace panoptic
