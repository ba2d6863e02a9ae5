// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "panoptic/frame_statistics.h"
#include "panoptic/fusion/reference_labels.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/parallel.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/drifting.h"

namespace panoptic {
namespace {

using namespace test::drifting;
using test::error_of;
using testing::HasSubstr;

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

TEST(Correction, LabelsThatComeAfterItTakeTheCorrectedPose) {
  const auto labelled_late = [](const Frame& frame) {
    Mapper mapper(often(), test::test_labels());
    for (int i = 0; i < 8; ++i) EXPECT_TRUE(mapper.add_geometry(drifted_frame(i)).used);
    mapper.update_poses(true_poses(8), read_again);
    EXPECT_TRUE(mapper.add_labels(frame, segmentation_of(7)).used);
    return hashes_of(mapper.map());
  };
  EXPECT_EQ(labelled_late(drifted_frame(7)), labelled_late(true_frame(7)));
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

}  // namespace
}  // namespace panoptic
