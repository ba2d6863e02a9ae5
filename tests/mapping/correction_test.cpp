// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "panoptic/base/files.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/fusion/reference_labels.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mapping/rebuild_file.h"
#include "panoptic/parallel.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/fusion/scenes.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

constexpr int kFrames = 30;

// Two balls on a table top, seen from an orbit. Labels waver as those of networks do; every fifth frame has none.
Frame true_frame(int i) {
  static const std::vector<Frame> kAll = [] {
    std::vector<Frame> frames;
    const test::Surface scene =
        test::nearest_of({test::sphere({0, 0, 0}, 0.4), test::sphere({0.7, 0.3, 0}, 0.25), test::plane(Vec3d::UnitY(), 0.5)});
    for (int k = 0; k < kFrames; ++k) {
      const double angle = 0.2 * k;
      frames.push_back(test::render(scene, test::small_camera(),
                                    test::look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), 3 * k));
    }
    return frames;
  }();
  return kAll[static_cast<std::size_t>(i)];
}

Segmentation segmentation_of(int i) {
  if (i % 5 == 3) return {};
  const Frame frame = true_frame(i);
  const ClassId chair{3};
  Segmentation s{Image<std::uint16_t>(frame.color.width(), frame.color.height()),
                 {{chair, 0.9F, {{chair, 0.7F}, {ClassId{1}, 0.3F}}}, {ClassId{2}, 1, {}}, {chair, 0.8F, {}}}};
  std::uint32_t state = static_cast<std::uint32_t>(frame.index) * 747796405U + 1;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      const int segment = p.y() > 0.499 ? 2 : p.x() > 0.45 ? 3 : 1;
      state = state * 1664525U + 1013904223U;
      s.segment_at(u, v) = static_cast<std::uint16_t>(state >> 24 < 8 ? state >> 16 & 3 : segment);
    }
  }
  return s;
}

// Drift that grows to half a metre: the second round sees everything twice.
Pose drifted(int i) {
  const Pose truth = true_frame(i).world_from_camera;
  const double share = static_cast<double>(i) / kFrames;
  Pose drift = Pose::Identity();
  drift.translation() = Vec3d(0.5, 0.05, -0.3) * share;
  drift.linear() = Eigen::AngleAxisd(0.1 * share, Vec3d::UnitY()).toRotationMatrix();
  return drift * truth;
}

Frame drifted_frame(int i) {
  Frame frame = true_frame(i);
  frame.time_s = 0.1 * i;
  frame.world_from_camera = drifted(i);
  return frame;
}

std::vector<PoseUpdate> true_poses(int end = kFrames) {
  std::vector<PoseUpdate> poses;
  for (int i = 0; i < end; ++i) poses.push_back({3 * i, true_frame(i).world_from_camera});
  return poses;
}

ReadResult read_again(std::int64_t frame) { return {drifted_frame(static_cast<int>(frame / 3)), {}}; }

Options often() {
  Options options;
  options.objects.every_frames = 4;
  options.regularizer.every_frames = 7;
  options.map.log = "reference";
  options.map.voxel_size_m = 0.04F;
  return options;
}

void add_frames(Mapper& mapper, int begin = 0, int end = kFrames) {
  for (int i = begin; i < end; ++i) ASSERT_EQ(mapper.add(drifted_frame(i), segmentation_of(i)), Outcome{});
}

struct Hashes {
  std::uint64_t voxels = 0;
  std::uint64_t free_space = 0;
  bool operator==(const Hashes&) const = default;
};
Hashes hashes_of(const PanopticMap& map) { return {map.voxels.hash(), map.free_space.hash()}; }

// The definition: a new map from the frames in their order, with the ids that were given resolved through `merged`, pixel by
// pixel, no tasks between.
class MadeFromScratch {
 public:
  MadeFromScratch(std::vector<std::vector<PanopticId>> given, ObjectRegistry merged)
      : given_(std::move(given)), merged_(std::move(merged)) {
    Options options = often();
    options.objects.every_frames = 1'000'000;
    options.regularizer.every_frames = 1'000'000;
    const auto associate = [this](const FrameToLabel& to_label, PanopticMap& map) { return associated(to_label, map); };
    parts_ = std::make_unique<MapperParts>(options, test::test_labels(), ReplacedStages{associate, {}});
    for (int i = 0; i < kFrames; ++i) {
      at_ = static_cast<std::size_t>(i);
      EXPECT_TRUE(parts_->add(true_frame(i), segmentation_of(i)).used);
    }
  }
  MapperParts& parts() { return *parts_; }

 private:
  LabelSlot slot_of(PanopticId id, const Segment& segment, PanopticMap& map) {
    const PanopticId now = merged_.survivor(id);
    if (number(now) < map.objects.first_thing()) return static_cast<LabelSlot>(number(now));
    const auto [place, is_new] = slot_of_.try_emplace(now);
    if (is_new) place->second = map.objects.create().value();
    map.objects.observe(place->second, segment, 3 * static_cast<std::int64_t>(at_));
    return place->second;
  }

  Association associated(const FrameToLabel& to_label, PanopticMap& map) {
    const auto& [frame, segmentation, registered] = to_label;
    reference_labels(map.voxels, frame, registered, reference_);
    labels_.assign(registered.segment.size(), LabelSlot::kNoVote);
    areas_.assign(segmentation.segments.size(), 0);
    for (std::size_t i = 0; i < reference_.size(); ++i) {
      const std::uint16_t value = registered.segment[i];
      if (value > 0 && value != RegisteredFrame::kNoSegment) ++areas_[value - 1U];
    }
    std::vector<std::size_t> order(areas_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return areas_[a] > areas_[b]; });
    slots_.resize(order.size());
    for (const std::size_t s : order) slots_[s] = slot_of(given_[at_][s], segmentation.segments[s], map);
    for (std::size_t i = 0; i < reference_.size(); ++i) {
      const std::uint16_t value = registered.segment[i];
      if (value == RegisteredFrame::kNoSegment) continue;
      labels_[i] = value == 0 ? LabelSlot::kUnknown : slots_[value - 1U];
      if (!map.labels.is_object(reference_[i]) || map.class_of(reference_[i]) != ClassId::kUnknown) continue;
      const bool says_less = value == 0 || map.labels.is_support(segmentation.segments[value - 1U].class_id);
      if (says_less) labels_[i] = reference_[i];
    }
    return {labels_, slots_, areas_};
  }

  std::vector<std::vector<PanopticId>> given_;
  ObjectRegistry merged_;
  std::map<PanopticId, LabelSlot> slot_of_;
  std::size_t at_ = 0;
  std::vector<LabelSlot> labels_;
  std::vector<LabelSlot> slots_;
  std::vector<std::uint32_t> areas_;
  std::vector<LabelSlot> reference_;
  std::unique_ptr<MapperParts> parts_;
};

TEST(Correction, IsTheMapMadeFromScratchOfTheLoggedFramesAtAnyThreadCount) {
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    MapperParts mapper(often(), test::test_labels());
    std::vector<std::vector<PanopticId>> given;
    for (int i = 0; i < kFrames; ++i) {
      ASSERT_TRUE(mapper.add(drifted_frame(i), segmentation_of(i)).used);
      const bool labelled = !segmentation_of(i).segments.empty();
      given.push_back(labelled ? mapper.segment_ids() : std::vector<PanopticId>());
    }
    mapper.finish();
    const Hashes wrong = hashes_of(mapper.map());
    const std::size_t merged = mapper.map().objects.merged().size();
    const Correction correction = mapper.fuse_anew(true_poses(), read_again);
    EXPECT_EQ(correction.frames, static_cast<std::size_t>(kFrames - 1)) << "the first pose is right already";
    EXPECT_EQ(correction.blocks, mapper.map().voxels.block_count());
    EXPECT_NE(hashes_of(mapper.map()), wrong);
    EXPECT_GT(mapper.map().objects.merged().size(), merged) << "a ball that was mapped twice";
    MadeFromScratch scratch(given, mapper.map().objects);
    EXPECT_EQ(hashes_of(mapper.map()), hashes_of(scratch.parts().map())) << threads << " threads";
    mapper.finish();
    scratch.parts().finish();
    EXPECT_EQ(hashes_of(mapper.map()), hashes_of(scratch.parts().map())) << threads << " threads";
  }
  set_thread_count(0);
}

// How much of the mesh lies farther than that from the surfaces that there are.
double share_of_ghosts(Mapper& mapper) {
  const auto distance = [](const Vec3d& p) {
    const double ball = std::abs((p - Vec3d(0, 0, 0)).norm() - 0.4);
    const double small_ball = std::abs((p - Vec3d(0.7, 0.3, 0)).norm() - 0.25);
    return std::min({ball, small_ball, std::abs(p.y() - 0.5)});
  };
  const Mesh mesh = mapper.mesh();
  const auto ghosts = std::count_if(mesh.vertices.begin(), mesh.vertices.end(),
                                    [&](const MeshVertex& v) { return distance(v.position.cast<double>()) > 0.03; });
  return static_cast<double>(ghosts) / static_cast<double>(mesh.vertices.size());
}

TEST(Correction, TakesGhostsAwayAndObjectsKeepTheirIds) {
  Mapper mapper(often(), test::test_labels());
  add_frames(mapper);
  std::vector<PanopticId> before;
  for (const Object& object : mapper.map().objects.state().objects) {
    if (object.id != PanopticId::kUnknown && object.observations > 3) before.push_back(object.id);
  }
  EXPECT_GT(share_of_ghosts(mapper), 0.2);
  mapper.update_poses(true_poses(), read_again);
  EXPECT_LT(share_of_ghosts(mapper), 0.01);
  mapper.finish();
  ASSERT_GE(before.size(), 2U);
  std::size_t there = 0;
  for (const PanopticId id : before) there += mapper.map().objects.find(mapper.map().objects.survivor(id)) != nullptr ? 1 : 0;
  EXPECT_EQ(there, before.size());
  const auto& objects = mapper.map().objects.state().objects;
  const auto seen_often = std::ranges::count_if(objects, [](const Object& object) { return object.observations > 3; });
  EXPECT_EQ(seen_often, 2) << "a ball is one chair, the other one another; labels waver where one hides the other";
  EXPECT_TRUE(mapper.frames().trajectory().back().world_from_camera.isApprox(true_frame(kFrames - 1).world_from_camera));
}

TEST(Correction, ChangesNothingWhereNoPoseMoves) {
  Mapper mapper(often(), test::test_labels());
  add_frames(mapper, 0, 12);
  const Hashes before = hashes_of(mapper.map());
  const std::uint64_t epoch = mapper.map().voxels.epoch();
  EXPECT_EQ(mapper.update_poses({}, read_again).frames, 0U);
  std::vector<PoseUpdate> same;
  for (int i = 0; i < 12; ++i) same.push_back({3 * i, drifted(i)});
  same[3].world_from_camera.translation().x() += 0.001;  // below map.pose_tolerance_m
  EXPECT_EQ(mapper.update_poses(same, read_again).frames, 0U);
  EXPECT_EQ(hashes_of(mapper.map()), before);
  EXPECT_EQ(mapper.map().voxels.epoch(), epoch);

  EXPECT_GT(mapper.update_poses(true_poses(12), read_again).frames, 0U);
  const Hashes corrected = hashes_of(mapper.map());
  EXPECT_EQ(mapper.update_poses(true_poses(12), read_again).frames, 0U) << "they are the map's poses now";
  EXPECT_EQ(hashes_of(mapper.map()), corrected);
}

TEST(Correction, TheSameWayOfCorrectionsGivesTheSameMapWithAMemoryLimitToo) {
  const auto corrected_on_the_way = [](const Options& options) {
    Mapper mapper(options, test::test_labels());
    for (int end : {10, 20, kFrames}) {
      add_frames(mapper, end - 10, end);
      mapper.update_poses(true_poses(end), read_again);
    }
    mapper.finish();
    EXPECT_LT(share_of_ghosts(mapper), 0.01);
    return hashes_of(mapper.map());
  };
  const Hashes expected = corrected_on_the_way(often());
  EXPECT_EQ(corrected_on_the_way(often()), expected);
  Options limited = often();
  limited.map.memory_limit_mb = 1000;
  limited.map.swap_folder = test::fresh_folder().string();
  EXPECT_EQ(corrected_on_the_way(limited), expected);
}

TEST(Correction, FollowsLabelsThatCameLater) {
  Mapper together(often(), test::test_labels());
  Mapper apart(often(), test::test_labels());
  for (int i = 0; i < 8; ++i) {
    ASSERT_TRUE(together.add(drifted_frame(i), segmentation_of(i)).used);
    ASSERT_TRUE(apart.add_geometry(drifted_frame(i)).used);
    ASSERT_TRUE(apart.add_labels(drifted_frame(i), segmentation_of(i)).used);
  }
  together.update_poses(true_poses(8), read_again);
  apart.update_poses(true_poses(8), read_again);
  EXPECT_EQ(hashes_of(apart.map()), hashes_of(together.map()));
}

TEST(Correction, WhatCannotBeDoneLeavesTheMapAsItWas) {
  Mapper mapper(often(), test::test_labels());
  add_frames(mapper, 0, 10);
  const Hashes before = hashes_of(mapper.map());
  std::vector<PoseUpdate> poses = true_poses(10);
  const auto says = [&](const char* what, const ReadFrame& read = read_again) {
    EXPECT_THAT(error_of([&] { mapper.update_poses(poses, read); }), HasSubstr(what));
    EXPECT_EQ(hashes_of(mapper.map()), before);
  };
  poses[4].world_from_camera.translation().x() = std::numeric_limits<double>::quiet_NaN();
  says("the corrected pose of frame 12 is no rigid motion");
  poses[4].world_from_camera = Pose::Identity();
  poses[4].world_from_camera.linear() *= 1.1;
  says("the corrected pose of frame 12 is no rigid motion");
  poses[4].world_from_camera = Pose::Identity();
  poses[4].world_from_camera.translation().x() = 1e9;
  says("frame 12 cannot be fused again: pose lies farther out than a map reaches");
  poses = true_poses(10);
  says("frame 15 cannot be read again: the disk is gone", [](std::int64_t frame) {
    return frame == 15 ? ReadResult{std::nullopt, {15, "the disk is gone"}} : read_again(frame);
  });

  poses.push_back({99, Pose::Identity()});
  poses.push_back({102, Pose::Identity()});
  const Correction correction = mapper.update_poses(poses, read_again);
  EXPECT_EQ(correction.unknown, 2U);
  EXPECT_EQ(correction.first_unknown, 99);
  EXPECT_EQ(correction.frames, 9U);
}

TEST(Correction, NeedsFramesWithNumbersOfTheirOwn) {
  Mapper mapper(often(), test::test_labels());
  add_frames(mapper, 0, 3);
  Frame again = drifted_frame(4);
  again.index = 3;
  ASSERT_TRUE(mapper.add(again, {}).used);
  EXPECT_THAT(error_of([&] { mapper.update_poses(true_poses(3), read_again); }), HasSubstr("have the same number"));
}

TEST(Correction, NeedsAWholeLog) {
  Options options = often();
  options.map.log = "none";
  Mapper without(options, test::test_labels());
  add_frames(without, 0, 3);
  EXPECT_THAT(error_of([&] { without.update_poses(true_poses(3), read_again); }), HasSubstr("map.log = none"));

  Mapper whole(often(), test::test_labels());
  add_frames(whole, 0, 6);
  MapperState state = whole.parts().state();
  state.log.pop_back();
  Mapper beyond(often(), test::test_labels());
  beyond.parts().restore(PanopticMap({}, test::test_labels()), std::move(state));
  EXPECT_THAT(error_of([&] { beyond.update_poses(true_poses(3), read_again); }),
              HasSubstr("its log tells of 5 of the 6 frames used; raise map.log_limit_mb"));
}

// A recording with the poses of a drifting tracker; every seventh position cannot be read.
class Drifting : public Dataset {
 public:
  std::string description() const override { return "drifting"; }
  std::size_t size() const override { return kFrames; }
  ReadResult read(std::size_t position) const override {
    const auto i = static_cast<int>(position);
    if (i % 7 == 6) return {std::nullopt, {3 * i, "unreadable"}};
    return {drifted_frame(i), {}};
  }
};

RunIdentity identity() { return {"somewhere", "", "", often()}; }

// Maps the recording up to a position with a map file, corrected once on the way if there are `poses`.
std::unique_ptr<Mapper> map_to_file(const std::filesystem::path& path, std::size_t end, bool complete,
                                    std::optional<std::size_t> correct_at = std::nullopt) {
  auto mapper = std::make_unique<Mapper>(often(), test::test_labels());
  Checkpoints checkpoints({.path = path, .resume = true, .every_s = 0}, identity(), *mapper);
  for (std::size_t position = checkpoints.positions(); position < end; ++position) {
    const ReadResult read = Drifting().read(position);
    if (read.frame) {
      const Segmentation s = segmentation_of(static_cast<int>(position));
      checkpoints.note(record_of(*read.frame, !s.segments.empty(), mapper->add(*read.frame, s)));
    } else {
      mapper->skip(read.skipped);
      checkpoints.note({.frame = read.skipped.index, .unused_because = read.skipped.reason});
    }
    if (position + 1 == correct_at) mapper->update_poses(true_poses(static_cast<int>(position) + 1), read_again);
    checkpoints.after_frame(*mapper);
  }
  if (complete) mapper->finish();
  checkpoints.finish(*mapper, complete);
  return mapper;
}

TEST(Correction, IsInTheMapFileAndARunGoesOnFromThere) {
  const auto folder = test::fresh_folder();
  const auto whole = map_to_file(folder / "whole.panoptic", kFrames, true, 15);
  const auto half = map_to_file(folder / "half.panoptic", 18, false, 15);
  const SavedMap saved = load_map(folder / "half.panoptic");
  EXPECT_EQ(hashes_of(saved.map), hashes_of(half->map()));
  for (const FrameRecord& record : load_frames(folder / "half.panoptic")) {
    if (!record.unused_because.empty()) continue;
    const auto i = static_cast<int>(record.frame / 3);
    EXPECT_TRUE(record.world_from_camera->isApprox(i < 15 ? true_frame(i).world_from_camera : drifted(i), 1e-9)) << i;
  }
  const auto resumed = map_to_file(folder / "half.panoptic", kFrames, true);
  EXPECT_EQ(hashes_of(resumed->map()), hashes_of(whole->map()));
  EXPECT_EQ(hashes_of(load_map(folder / "half.panoptic").map), hashes_of(whole->map()));
  // The log came through the file: a correction now is that of the run that was never interrupted.
  whole->update_poses(true_poses(), read_again);
  resumed->update_poses(true_poses(), read_again);
  EXPECT_EQ(hashes_of(resumed->map()), hashes_of(whole->map()));
}

std::string trajectory(bool by_time) {
  std::string text = "# x y z qx qy qz qw after a number\n";
  for (int i = 0; i < kFrames; ++i) {
    const Pose pose = true_frame(i).world_from_camera;
    const Eigen::Quaterniond q(pose.linear());
    text += fmt::format("{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", by_time ? 0.1 * i + 0.004 : 3.0 * i,
                        pose.translation().x(), pose.translation().y(), pose.translation().z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

class Rebuild : public testing::Test {
 protected:
  RebuiltFile rebuild(const std::string& poses, const std::filesystem::path& output) {
    write_file(folder_ / "poses.txt", poses);
    return rebuild_map_file(map_, folder_ / "poses.txt", recording_, output);
  }
  std::string error(const std::string& poses) {
    return error_of([&] { rebuild(poses, folder_ / "refused.panoptic"); });
  }

  std::filesystem::path folder_ = test::fresh_folder();
  std::filesystem::path map_ = folder_ / "drifted.panoptic";
  Drifting recording_;
};

TEST_F(Rebuild, MakesAMapFileAnewAsIfItsRunHadBeenCorrected) {
  const auto mapper = map_to_file(map_, kFrames, true);
  const std::uint64_t before = load_map(map_).map.voxels.hash();
  const RebuiltFile rebuilt = rebuild(trajectory(false), folder_ / "new.panoptic");
  EXPECT_EQ(rebuilt.used, mapper->frames().used());
  EXPECT_EQ(rebuilt.given, rebuilt.used);
  EXPECT_EQ(rebuilt.correction.unknown, 4U) << "frames that could not be read";

  std::vector<FrameTime> times;
  for (int i = 0; i < kFrames; ++i) times.push_back({3 * i, 0.1 * i});
  mapper->update_poses(read_corrected_poses(folder_ / "poses.txt", times).poses, read_again);
  const SavedMap saved = load_map(folder_ / "new.panoptic");
  EXPECT_EQ(hashes_of(saved.map), hashes_of(mapper->map()));
  EXPECT_EQ(saved.map.objects.state(), mapper->map().objects.state());
  EXPECT_EQ(load_map(map_).map.voxels.hash(), before);
  for (const FrameRecord& record : load_frames(folder_ / "new.panoptic")) {
    if (!record.unused_because.empty()) continue;
    EXPECT_TRUE(record.world_from_camera->isApprox(true_frame(static_cast<int>(record.frame / 3)).world_from_camera, 1e-9));
  }

  rebuild(trajectory(true), folder_ / "by_time.panoptic");
  EXPECT_EQ(load_map(folder_ / "by_time.panoptic").map.voxels.hash(), saved.map.voxels.hash());
  // A map that was made anew can be made anew.
  const RebuiltFile again =
      rebuild_map_file(folder_ / "new.panoptic", folder_ / "poses.txt", recording_, folder_ / "again.panoptic");
  EXPECT_EQ(again.correction.frames, 0U);
  EXPECT_EQ(load_map(folder_ / "again.panoptic").map.voxels.hash(), saved.map.voxels.hash());
}

TEST_F(Rebuild, SaysWhatIsWrong) {
  map_to_file(map_, 12, false);
  EXPECT_THAT(error("1 2 3\n"), HasSubstr("poses.txt"));
  EXPECT_THAT(error("0 0 0 0 0 0 1\n0 0 1 0 0 0 1\n"), HasSubstr("its poses have no numbers"));
  EXPECT_THAT(error("500.5 0 0 0 0 0 0 1\n501.5 0 0 1 0 0 0 1\n"),
              HasSubstr("of its 2 poses 0 have the number of a frame of the map, and 0 are within 20 ms of one"));
  EXPECT_FALSE(is_there(folder_ / "refused.panoptic"));
  EXPECT_THAT(error_of([&] { rebuild(trajectory(false), map_); }), HasSubstr("is there already"));

  std::filesystem::copy_file(test::source_folder() / "tests/golden/format_3.panoptic", folder_ / "old.panoptic");
  map_ = folder_ / "old.panoptic";
  EXPECT_THAT(error(trajectory(false)), HasSubstr("has format 3, which lacks the log of its frames"));
}

TEST_F(Rebuild, ARunDoesNotGoOnFromAMapWithOtherPoses) {
  map_to_file(map_, 12, false);
  EXPECT_EQ(rebuild(trajectory(false), folder_ / "new.panoptic").left_over, 30U - 11U) << "the map ends earlier";
  EXPECT_THAT(error_of([&] { map_to_file(folder_ / "new.panoptic", 14, false); }), HasSubstr("was rebuilt with corrected poses"));
}

}  // namespace
}  // namespace panoptic
