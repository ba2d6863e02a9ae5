// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map_pairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "panoptic/analysis/map_merge.h"
#include "panoptic/analysis/seen_space.h"
#include "panoptic/map/voxel_grid.h"
#include "tests/block_planes.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/fusion/scenes.h"
#include "tests/mapping/mapped.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using testing::HasSubstr;

constexpr double kFloor_m = 0.6;  // y points down

// A ball that is said to be a chair. Those are things.
struct Ball {
  Vec3d center;
  double radius_m = 0.3;
};
const Ball kStays{{0, 0.3, 0}, 0.3};
const Ball kFloats{{-0.9, -0.2, 0.1}, 0.2};  // far from every other surface: the distance field says nothing of its place
const Ball kSmall{{0.8, 0.4, 0.2}, 0.2};

test::LabelledView view_of(const std::vector<Ball>& balls, int i) {
  std::vector<test::Surface> surfaces{test::plane(Vec3d::UnitY(), kFloor_m)};
  for (const Ball& ball : balls) surfaces.push_back(test::sphere(ball.center, ball.radius_m));
  const double angle = 0.52 * i;
  const Pose pose = test::look_at({2.2 * std::cos(angle), -1.2, 2.2 * std::sin(angle)}, {0, 0.1, 0});
  const Frame frame = test::render(test::nearest_of(surfaces), test::small_camera(), pose, i);
  Segmentation s{Image<std::uint16_t>(160, 120), {{ClassId{2}, 1, {}}}};
  for (std::size_t k = 0; k < balls.size(); ++k) s.segments.push_back({ClassId{3}, 0.9F, {{ClassId{3}, 1.0F}}});
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      if (frame.depth(u, v) <= 0) continue;
      const Vec3d p = pose * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      s.segment_at(u, v) = 1;
      for (std::size_t k = 0; k < balls.size(); ++k) {
        if (std::abs((p - balls[k].center).norm() - balls[k].radius_m) < 1e-3)
          s.segment_at(u, v) = static_cast<std::uint16_t>(k + 2);
      }
    }
  }
  return {frame, s};
}

MapWithFrames map_of(const std::vector<Ball>& balls, int begin = 0, int end = 12) {
  RunIdentity run{"balls", "", "", {}};
  run.options.map.voxel_size_m = 0.04F;
  const auto path = fresh_folder() / "balls.panoptic";
  test::map_views([&](int i) { return view_of(balls, i); }, begin, end, run, test::test_labels(), path);
  return load_map_with_frames(path);
}

MapDiff diff(const MapWithFrames& a, const MapWithFrames& b) { return diff_maps(a, b, "A", "B"); }

std::vector<std::string> kinds(const MapDiff& d) {
  std::vector<std::string> all;
  for (const ObjectChange& c : d.changes) all.emplace_back(name_of(c.kind));
  return all;
}

TEST(MapDiff, NothingChangesBetweenAMapAndItself) {
  const MapWithFrames map = map_of({kStays, kSmall, kFloats});
  const MapDiff same = diff(map, map);
  EXPECT_THAT(kinds(same), testing::IsEmpty());
  EXPECT_EQ(same.unchanged, 3U);
  EXPECT_EQ(same.shift.common, 1);
  EXPECT_EQ(same.shift.p95_m, 0);
  EXPECT_THAT(same.notes, testing::IsEmpty());
}

// Poses that drifted between two visits put every surface elsewhere.
TEST(MapDiff, SaysHowFarSurfacesLieApart) {
  const MapWithFrames map = map_of({kStays, kSmall, kFloats});
  for (const auto& [shift_m, is_told] : {std::pair(0.02, false), std::pair(0.1, true)}) {
    const MapDiff shifted = diff(map, moved_map(map, Pose(Eigen::Translation3d(0, shift_m, 0))));
    EXPECT_NEAR(shifted.shift.median_m, shift_m, 0.006) << "of the floor, which is most of the surface";
    EXPECT_GT(shifted.shift.common, 0.8);
    EXPECT_EQ(shifted.notes.size(), is_told ? 1U : 0U);
    for (const std::string& note : shifted.notes) EXPECT_THAT(note, HasSubstr("cm apart (median), more than a voxel"));
  }
}

TEST(MapDiff, SaysWhatVanishedAndWhatAppearedAlsoInMidAir) {
  const MapWithFrames a = map_of({kStays, kFloats});
  const MapWithFrames b = map_of({kStays});
  const MapDiff gone = diff(a, b);
  ASSERT_THAT(kinds(gone), testing::ElementsAre("vanished"));
  EXPECT_EQ(gone.unchanged, 1U);
  ASSERT_TRUE(gone.changes[0].before.has_value());
  EXPECT_FALSE(gone.changes[0].after.has_value());
  EXPECT_LT((gone.changes[0].before->box.center_m - kFloats.center).norm(), 0.1);
  EXPECT_GT(gone.changes[0].empty_share, 0.5);
  const MapDiff come = diff(b, a);
  ASSERT_THAT(kinds(come), testing::ElementsAre("appeared"));
  EXPECT_LT((come.changes[0].after->box.center_m - kFloats.center).norm(), 0.1);
}

TEST(MapDiff, WhatTheOtherMapDidNotLookAtIsNotSaidToBeGone) {
  const MapWithFrames a = map_of({kStays, kFloats});
  MapWithFrames b = map_of({kStays});
  b.saved.map.free_space = FreeSpaceMap(b.saved.map.voxels.voxel_size_m());
  b.frames.clear();  // no camera looked anywhere, as far as is known
  EXPECT_THAT(kinds(diff(a, b)), testing::ElementsAre("not_seen_in_b"));
  EXPECT_THAT(kinds(diff(b, a)), testing::ElementsAre("not_seen_in_a"));
}

TEST(MapDiff, SaysWhatMovedAndHowFar) {
  Ball moved = kSmall;
  moved.center += Vec3d(-1.4, 0, 0.5);
  const MapWithFrames a = map_of({kStays, kSmall});
  const MapWithFrames b = map_of({kStays, moved});
  for (const bool forwards : {true, false}) {
    const MapDiff d = forwards ? diff(a, b) : diff(b, a);
    ASSERT_THAT(kinds(d), testing::ElementsAre("moved"));
    EXPECT_NEAR(d.changes[0].moved_m, std::hypot(1.4, 0.5), 0.08);
    EXPECT_LT((d.changes[0].after->box.center_m - (forwards ? moved : kSmall).center).norm(), 0.1);
  }
}

TEST(MapDiff, AnotherSizeIsAnotherThing) {
  const Ball large{{-0.8, 0.15, 0.6}, 0.45};
  const MapDiff d = diff(map_of({kStays, kSmall}), map_of({kStays, large}));
  EXPECT_THAT(kinds(d), testing::ElementsAre("vanished", "appeared"));
}

TEST(MapDiff, WhatOnlyLostItsLabelIsNotGone) {
  const MapWithFrames a = map_of({kStays, kSmall});
  MapWithFrames b = map_of({kStays, kSmall});
  const MapQuery query(b.saved.map);
  const LabelSlot small = query.nearest(kSmall.center, 1).at(0).object.slot;
  for (Slot slot = 0; slot < b.saved.map.voxels.block_count(); ++slot) {
    test::BlockEdit edit(b.saved.map.voxels.block(slot));
    for (std::uint16_t& label : edit->label) label = label == number(small) ? std::uint16_t{2} : label;
  }
  const MapDiff d = diff(a, b);
  ASSERT_THAT(kinds(d), testing::ElementsAre("other_label"));
  EXPECT_EQ(d.unchanged, 1U);
}

TEST(MapDiff, RefusesMapsThatDoNotFit) {
  const MapWithFrames a = map_of({kStays}, 0, 2);
  MapWithFrames b = map_of({kStays}, 0, 2);
  b.saved.options.voxel_size_m = 0.03F;
  EXPECT_THAT(test::error_of([&] { (void)diff(a, b); }), HasSubstr("A has voxels of 0.04 m"));
}

TEST(MapDiff, GuessesWhatAMapWithoutFreeSpaceSawAndSaysSo) {
  const MapWithFrames a = map_of({kStays, kFloats});
  MapWithFrames b = map_of({kStays});
  EXPECT_THAT(diff(a, b).notes, testing::IsEmpty());
  b.saved.map.free_space = FreeSpaceMap(b.saved.map.voxels.voxel_size_m());
  const MapDiff guessed = diff(a, b);
  EXPECT_THAT(kinds(guessed), testing::ElementsAre("vanished"));
  EXPECT_THAT(guessed.notes, testing::ElementsAre(HasSubstr("B has no free space")));
}

// A thing that was there in the first map alone, in mid-air.
TEST(MapMerge, ClearsWhatTheSecondMapLookedThrough) {
  const auto surface_of_ball = [](const SavedMap& saved) {
    std::size_t voxels = 0;
    const VoxelMap& map = saved.map.voxels;
    for (Slot slot = 0; slot < map.block_count(); ++slot) {
      visit_surface(map.block(slot), map.index_of(slot), map.voxel_size_m(), [&](LabelSlot, const VoxelIndex& voxel) {
        voxels += (center_m(voxel, map.voxel_size_m()) - kFloats.center).norm() < 0.3 ? 1 : 0;
      });
    }
    return voxels;
  };
  MapWithFrames blind = map_of({kStays});
  blind.saved.map.free_space = FreeSpaceMap(blind.saved.map.voxels.voxel_size_m());
  const std::size_t before = surface_of_ball(merge_maps(map_of({kStays, kFloats}), blind, "A", "B").merged.saved);
  EXPECT_GT(before, 200U);
  const MapMerge merge = merge_maps(map_of({kStays, kFloats}), map_of({kStays}), "A", "B");
  EXPECT_LT(surface_of_ball(merge.merged.saved), before / 7) << "a rim may stay";
  EXPECT_EQ(merge.merged.saved.map.free_space.at(*blind.saved.map.free_space.cell_around(kFloats.center)), Space::kFree);
}

TEST(SeenSpace, IsTheFreeSpaceOfTheMap) {
  const MapWithFrames map = map_of({kStays}, 0, 12);
  const SeenSpace space(map.saved.map, {}, 8);
  EXPECT_FALSE(space.is_guessed());
  EXPECT_EQ(space.at({0, -0.4, 0}), Occupancy::kFree);
  EXPECT_EQ(space.at({0, 0, 0}), Occupancy::kSurface);
  EXPECT_EQ(space.at({0, 0.25, 0}), Occupancy::kUnseen) << "inside the ball";
  EXPECT_EQ(space.at({9, 0, 9}), Occupancy::kUnseen);
}

TEST(SeenSpace, WithoutFreeSpaceIsWhatACameraLookedThrough) {
  MapWithFrames map = map_of({kStays}, 0, 1);
  map.saved.map.free_space = FreeSpaceMap(map.saved.map.voxels.voxel_size_m());
  const SeenSpace space(map.saved.map, map.frames, 8);
  EXPECT_TRUE(space.is_guessed());
  const Pose camera = *map.frames.at(0).world_from_camera;
  const auto ahead = [&](double distance_m) -> Vec3d { return camera * Vec3d(0, 0, distance_m); };
  EXPECT_EQ(space.at(ahead(0.5)), Occupancy::kFree);
  EXPECT_EQ(space.at(ahead(1.5)), Occupancy::kFree);
  const double hit_m = *test::sphere(kStays.center, kStays.radius_m)(camera.translation(), camera.linear().col(2));
  EXPECT_EQ(space.at(ahead(hit_m)), Occupancy::kSurface);
  EXPECT_EQ(space.at(ahead(hit_m - 0.1)), Occupancy::kFree) << "within the truncation";
  EXPECT_EQ(space.at(ahead(hit_m + 0.3)), Occupancy::kUnseen);
  EXPECT_EQ(space.at(ahead(-1)), Occupancy::kUnseen) << "behind the camera";
  EXPECT_EQ(space.at(camera * Vec3d(1, 0, 0.5)), Occupancy::kUnseen) << "outside its view";
  EXPECT_EQ(SeenSpace(map.saved.map, map.frames, 1).at(ahead(0.9)), Occupancy::kUnseen) << "no surface within reach";
  EXPECT_EQ(SeenSpace(map.saved.map, {}, 8).at(ahead(0.5)), Occupancy::kUnseen);
  EXPECT_EQ(space.at(Vec3d::Constant(std::nan(""))), Occupancy::kUnseen);
}

}  // namespace
}  // namespace panoptic
