// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "panoptic/base/compression.h"
#include "panoptic/base/files.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/map/block_pager.h"
#include "panoptic/mapfile/map_lock.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/outputs.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/two_balls.h"
#include "tests/places.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::HasSubstr;

constexpr int kFrames = 24;

// Pose, labels and numbers of segments waver as those of networks do.
Frame rendered(int i) {
  Frame frame = test::two_balls(0.1 * i, 5 * i);
  frame.time_s = 0.1 * i;
  return frame;
}

const Frame& frame_at(int i) {
  static const std::vector<Frame> kAll = [] {
    std::vector<Frame> frames;
    for (int k = 0; k < kFrames; ++k) frames.push_back(rendered(k));
    return frames;
  }();
  return kAll[static_cast<std::size_t>(i)];
}

Segmentation segmentation_of(const Frame& frame) { return test::wavering(frame, 40); }

RunIdentity identity() {
  RunIdentity run{"somewhere", "", "", {}};
  run.options.objects.every_frames = 4;
  run.options.regularizer.every_frames = 7;
  return run;
}

std::string objects_text(Mapper& mapper) {
  const Mesh mesh = mapper.mesh();
  return objects_json(mapper, mesh).dump() + fmt::format("{} vertices {} triangles", mesh.vertices.size(), mesh.triangles.size());
}

void map_frame(int i, Mapper& mapper, Checkpoints* checkpoints) {
  const Frame& frame = frame_at(i);
  FrameRecord record{.frame = frame.index, .time_s = 0.1 * i, .world_from_camera = frame.world_from_camera};
  if (i % 9 == 5) {
    record.unused_because = "color image is unreadable";
    mapper.skip({frame.index, record.unused_because});
  } else {
    record.labelled = i % 5 != 3;
    record.unused_because = mapper.add(frame, record.labelled ? segmentation_of(frame) : Segmentation{}).reason;
  }
  if (checkpoints == nullptr) return;
  checkpoints->note(record);
  checkpoints->after_frame(mapper);
}

struct Whole {
  std::uint64_t hash = 0;
  std::uint64_t free_space = 0;
  std::string objects;
};
const Whole& uninterrupted() {
  static const Whole kWhole = [] {
    Mapper mapper(identity().options, test::test_labels());
    for (int i = 0; i < kFrames; ++i) map_frame(i, mapper, nullptr);
    mapper.finish();
    return Whole{mapper.map().voxels.hash(), mapper.map().free_space.hash(), objects_text(mapper)};
  }();
  return kWhole;
}

CheckpointSettings settings(const std::filesystem::path& path, bool resume = true, double every_s = 1e9) {
  return {.path = path, .resume = resume, .every_s = every_s};
}

// Maps up to the position, or to the end.
void map_until(int end, const std::filesystem::path& path, std::optional<int> finish_at = std::nullopt) {
  Mapper mapper(identity().options, test::test_labels());
  Checkpoints checkpoints(settings(path), identity(), mapper);
  for (int i = static_cast<int>(checkpoints.positions()); i < end; ++i) map_frame(i, mapper, &checkpoints);
  if (finish_at) mapper.finish();
  checkpoints.finish(mapper, finish_at.has_value());
}

TEST(Resume, GivesTheSameMapAndObjectsWhereverItWasInterrupted) {
  // After the first frame, a regularization (7), a maintenance (8), both, a skipped frame (5), twice, right before the end.
  const std::vector<std::vector<int>> all = {{1, 7, 16}, {8, 14}, {9, 15, 17}, {kFrames}};
  for (const std::vector<int>& cuts : test::third_under_a_sanitizer(all)) {
    const auto path = fresh_folder() / "map.panoptic";
    for (const int cut : cuts) map_until(cut, path);
    Mapper mapper(identity().options, test::test_labels());
    Checkpoints checkpoints(settings(path), identity(), mapper);
    ASSERT_EQ(checkpoints.positions(), static_cast<std::uint64_t>(cuts.back()));
    for (int i = cuts.back(); i < kFrames; ++i) map_frame(i, mapper, &checkpoints);
    mapper.finish();
    checkpoints.finish(mapper, true);
    EXPECT_EQ(mapper.map().voxels.hash(), uninterrupted().hash) << cuts.front();
    EXPECT_EQ(mapper.map().free_space.hash(), uninterrupted().free_space) << cuts.front();
    EXPECT_EQ(load_map(path).map.free_space.hash(), uninterrupted().free_space) << cuts.front();
    EXPECT_EQ(objects_text(mapper), uninterrupted().objects) << cuts.front();
    EXPECT_EQ(mapper.frames().skipped(), 3U);
    EXPECT_EQ(mapper.frames().used(), 21U);
    EXPECT_EQ(load_map(path).map.voxels.hash(), uninterrupted().hash);
  }
}

TEST(Resume, DoesNotGoOnFromAnOlderFormatNorFromAMapThatWasOneBefore) {
  const auto path = fresh_folder() / "map.panoptic";
  std::filesystem::copy_file(test::source_folder() / "tests/golden/format_1.panoptic", path);
  const auto complaint = [&] {
    Mapper mapper(identity().options, test::test_labels());
    return error_of([&] { Checkpoints(settings(path), identity(), mapper); });
  };
  EXPECT_THAT(complaint(), HasSubstr("was made in format 1, which tells less than a run needs to go on"));
  const SavedMap saved = load_map(path);
  EXPECT_THAT(error_of([&] { MapFileWriter::open(path, MapLock(path), saved); }), HasSubstr("has format 1"));
  MapUpdate update = whole_map(saved.map);
  update.notes = saved.notes;
  update.notes.texts[run_note::kFromFormat] = "1";
  save_map(path, saved.header(), update);
  EXPECT_EQ(load_map(path).format, kMapFormat);
  EXPECT_EQ(load_map(path).map.voxels.hash(), saved.map.voxels.hash());
  EXPECT_THAT(complaint(), HasSubstr("was made in format 1"));
}

// A checkpoint that was written meanwhile, with the process gone before it could close the file: as SQLite leaves it, log and
// all.
TEST(Resume, GoesOnFromTheLastCheckpointOfAProcessThatIsGone) {
  const auto path = fresh_folder() / "map.panoptic";
  const auto left = fresh_folder("left") / "map.panoptic";
  {
    Mapper mapper(identity().options, test::test_labels());
    Checkpoints checkpoints(settings(path, false, 0), identity(), mapper);
    for (int i = 0; i < 13; ++i) map_frame(i, mapper, &checkpoints);
    for (const char* suffix : {"", "-wal"}) std::filesystem::copy_file(path.string() + suffix, left.string() + suffix);
  }
  Mapper mapper(identity().options, test::test_labels());
  Checkpoints checkpoints(settings(left), identity(), mapper);
  EXPECT_LE(checkpoints.positions(), 13U);
  for (int i = static_cast<int>(checkpoints.positions()); i < kFrames; ++i) map_frame(i, mapper, &checkpoints);
  mapper.finish();
  EXPECT_EQ(mapper.map().voxels.hash(), uninterrupted().hash);
}

// Where a map lies in memory is nobody's business but the machine's: a run may be resumed with less.
TEST(Resume, MayTakeLessMemoryThanTheRunBefore) {
  const auto path = fresh_folder() / "map.panoptic";
  RunIdentity frugal = identity();
  frugal.options.map.memory_limit_mb = 8;  // no map is refused for it once it has frames
  frugal.options.map.swap_folder = path.parent_path().string();
  map_until(13, path);
  Mapper mapper(frugal.options, test::test_labels());
  Checkpoints checkpoints(settings(path), frugal, mapper);
  for (int i = 13; i < kFrames; ++i) map_frame(i, mapper, &checkpoints);
  mapper.finish();
  ASSERT_NE(mapper.map().voxels.pager(), nullptr);
  EXPECT_GT(mapper.map().voxels.pager()->blocks_given_back(), mapper.map().voxels.block_count());
  EXPECT_EQ(mapper.map().voxels.hash(), uninterrupted().hash);
  EXPECT_EQ(objects_text(mapper), uninterrupted().objects);
  checkpoints.finish(mapper, true);
  EXPECT_EQ(load_map(path, frugal.options.map).map.voxels.hash(), uninterrupted().hash);
}

// 72 frames, of which 2 are labelled: to have been seen once is enough, as it is in a recording of 2 frames.
TEST(Resume, ObservationsAreAskedForByLabelledFramesAlsoOfTheRunBefore) {
  const auto add = [](int i, Mapper& mapper, Checkpoints& checkpoints) {
    const Frame& frame = frame_at(i % kFrames);
    const bool labelled = i == 30 || i == 60;
    Segmentation segmentation = labelled ? segmentation_of(frame) : Segmentation{};
    if (i == 60) segmentation.segments[0] = segmentation.segments[2] = {ClassId{1}, 1, {}};  // the balls are missed
    ASSERT_EQ(mapper.add(frame, segmentation), Outcome{});
    checkpoints.note({.frame = i, .time_s = 0.1 * i, .world_from_camera = frame.world_from_camera, .labelled = labelled});
  };
  RunIdentity run = identity();
  run.options.regularizer.enabled = false;
  const auto path = fresh_folder() / "map.panoptic";
  {
    Mapper mapper(run.options, test::test_labels());
    Checkpoints checkpoints(settings(path), run, mapper);
    for (int i = 0; i < 40; ++i) add(i, mapper, checkpoints);
    checkpoints.finish(mapper, false);
  }
  Mapper mapper(run.options, test::test_labels());
  Checkpoints checkpoints(settings(path), run, mapper);
  for (int i = 40; i < 72; ++i) add(i, mapper, checkpoints);
  mapper.finish();
  EXPECT_EQ(mapper.labelled(), 2U);
  const std::vector<Object> all = mapper.map().objects.state().objects;
  EXPECT_TRUE(std::any_of(all.begin(), all.end(), [](const Object& o) { return o.observations == 1; }));
}

TEST(Resume, RefusesAFileThatLacksTheFramesOfItsMap) {
  const auto path = fresh_folder() / "map.panoptic";
  {
    Mapper mapper(identity().options, test::test_labels());
    Checkpoints checkpoints(settings(path), identity(), mapper);
    ASSERT_EQ(mapper.add(frame_at(0), Segmentation{}), Outcome{});  // and not noted
    checkpoints.finish(mapper, false);
  }
  Mapper mapper(identity().options, test::test_labels());
  EXPECT_THAT(error_of([&] { Checkpoints(settings(path), identity(), mapper); }), HasSubstr("lacks frames"));
}

TEST(Resume, OfACompleteMapHasNothingToDo) {
  const auto path = fresh_folder() / "map.panoptic";
  map_until(kFrames, path, 1);
  Mapper mapper(identity().options, test::test_labels());
  const Checkpoints checkpoints(settings(path), identity(), mapper);
  EXPECT_TRUE(checkpoints.was_complete());
  EXPECT_EQ(mapper.map().voxels.hash(), uninterrupted().hash);
  EXPECT_EQ(objects_text(mapper), uninterrupted().objects);
}

TEST(Resume, RefusesAnotherRecordingOtherOptionsAndOtherLabels) {
  const auto path = fresh_folder() / "map.panoptic";
  map_until(2, path);
  const auto complaint = [&](const RunIdentity& run, const LabelSet& labels) {
    return error_of([&] {
      Mapper mapper(run.options, labels);
      Checkpoints(settings(path), run, mapper);
    });
  };
  RunIdentity other = identity();
  other.recording = "elsewhere";
  EXPECT_THAT(complaint(other, test::test_labels()), HasSubstr("its recording is 'somewhere', here it is 'elsewhere'"));
  other = identity();
  other.options.map.voxel_size_m = 0.05F;
  EXPECT_THAT(complaint(other, test::test_labels()), HasSubstr("its options is 'voxel_size_m = 0.024"));
  other = identity();
  other.frames = "0:10";
  EXPECT_THAT(complaint(other, test::test_labels()), HasSubstr("frames_range"));
  EXPECT_THAT(complaint(identity(), load_label_set("indoor")), HasSubstr("its label set"));
  Mapper mapper(identity().options, test::test_labels());
  EXPECT_THAT(error_of([&] { Checkpoints(settings(path, false), identity(), mapper); }), HasSubstr("--resume"));
}

TEST(Resume, OfAFileThatIsBeingWrittenIsRefused) {
  const auto path = fresh_folder() / "map.panoptic";
  Mapper mapper(identity().options, test::test_labels());
  const Checkpoints checkpoints(settings(path, false), identity(), mapper);
  Mapper second(identity().options, test::test_labels());
  EXPECT_THAT(error_of([&] { Checkpoints(settings(path), identity(), second); }), HasSubstr("another run writes"));
}

TEST(Resume, RefusesStatesThatAreNotOfTheMap) {
  const auto path = fresh_folder() / "map.panoptic";
  map_until(10, path);
  const std::vector<FrameRecord> frames = load_frames(path);
  const auto complaint = [&](const char* name, const Bytes& bytes) {
    SavedMap saved = load_map(path);
    saved.notes.states[name] = bytes;
    return error_of([&] { mapper_state(saved, frames); });
  };
  EXPECT_THAT(complaint("together", {1, 2, 3}), HasSubstr("'together'"));
  EXPECT_THAT(complaint("together", {5, 0, 5, 0, 1, 0, 0, 0}), HasSubstr("'together'"));
  EXPECT_THAT(complaint("overruled", {1}), HasSubstr("'overruled'"));
  EXPECT_THAT(complaint("overruled", {255, 255}), HasSubstr("'overruled'"));
  EXPECT_THAT(complaint("overruled", {1, 0, 0, 0, 1, 0, 0, 0, 0x80, 0x7F, 1, 0, 0, 0, 0, 0}), HasSubstr("'overruled'"));
  EXPECT_THAT(complaint("overruled", {1, 0, 0, 0, 0xFF, 0xFF, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}), HasSubstr("'overruled'"));
  EXPECT_THAT(complaint("regularized", Bytes(8, 0xFF)), HasSubstr("'regularized'"));
  EXPECT_THAT(complaint("regularized", Bytes(80000, 0)), HasSubstr("'regularized'"));
  SavedMap saved = load_map(path);
  saved.notes.texts["session"] = "{\"label_frames\": -1}";
  EXPECT_THAT(error_of([&] { mapper_state(saved, frames); }), HasSubstr("'session'"));
}

}  // namespace
}  // namespace panoptic
