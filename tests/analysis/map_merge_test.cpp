// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/map_merge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <random>

#include "panoptic/analysis/object_matching.h"
#include "panoptic/map/label_extents.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/parallel.h"
#include "tests/block_planes.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/fusion/small_maps.h"

namespace panoptic {
namespace {

using test::error_of;
using test::pid;
using test::Solid;
using test::solid_box;
using test::solid_ground;
using testing::HasSubstr;

constexpr ClassId kFloor{1};
constexpr ClassId kTable{2};
constexpr ClassId kChair{3};
constexpr int kFirst = 4;

LabelSet labels() {
  return {"test",
          {{kFloor, "floor", false, {10, 20, 30}, 0, false},
           {kTable, "table", true, {40, 50, 60}, 2.5, true},
           {kChair, "chair", true, {70, 80, 90}, 1.25, false}}};
}

struct Thing {
  Vec3d low;
  Vec3d high;
  ClassId class_id;
};

constexpr double kFrom = -0.6;
constexpr double kTo = 0.6;

// Things on a floor at z = 0, observed in [low, high); the n-th is object kFirst + n, seen in frames 10 n to 10 n + 9.
MapWithFrames world(const std::vector<Thing>& things, const Vec3d& low = Vec3d::Constant(kFrom),
                    const Vec3d& high = Vec3d::Constant(kTo)) {
  MapWithFrames made{{MapOptions{}, PanopticMap(MapOptions{}, labels()), {}}, {}};
  std::vector<Solid> solids{solid_ground(Vec3d::UnitZ(), 0, pid(1))};
  for (const Thing& thing : things) {
    const LabelSlot id = *made.saved.map.objects.create();
    solids.push_back(solid_box(thing.low, thing.high, id));
    for (int k = 0; k < 10; ++k) {
      const std::int64_t frame = 10 * (number(id) - kFirst) + k;
      made.saved.map.objects.observe(id, {thing.class_id, 0.5F, {}}, frame);
      made.saved.map.objects.show(id, {frame, thing.class_id, 0.5F, 100, {0, 0, 10, 10}});
      made.frames.push_back({.position = static_cast<std::int64_t>(made.frames.size()), .frame = frame});
    }
  }
  add_solids(made.saved.map.voxels, solids, low, high);
  for (Slot slot = 0; slot < made.saved.map.voxels.block_count(); ++slot) {
    test::BlockEdit block_edit(made.saved.map.voxels.block(slot));
    BlockPlanes& block = *block_edit;
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      if (block.distance[v] < made.saved.map.voxels.truncation_m()) continue;  // integration leaves air alone
      block.distance[v] = block.weight[v] = block.label_weight[v] = block.vote_sum[v] = 0;
      block.label[v] = 0;
    }
  }
  return made;
}

MapMerge merged(MapWithFrames a, const MapWithFrames& b) { return merge_maps(std::move(a), b, "A", "B"); }

const Thing kLeft{{-0.5, -0.1, 0}, {-0.2, 0.2, 0.3}, kChair};
const Thing kRight{{0.2, -0.1, 0}, {0.5, 0.2, 0.3}, kChair};
const Thing kMiddle{{-0.1, -0.1, 0}, {0.1, 0.1, 0.4}, kTable};

void fill(BlockPlanes& block, std::mt19937& random) {
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    if (random() % 3 == 0) continue;
    block.distance[v] = static_cast<float>(random() % 200) * 1e-3F - 0.1F;
    block.weight[v] = static_cast<float>(random() % 1000 + 1) * 0.013F;
    block.label_weight[v] = static_cast<float>(random() % 8);
    block.vote_sum[v] = block.label_weight[v] + static_cast<float>(random() % 4);
    block.label[v] = static_cast<std::uint16_t>(random() % 7);
    for (auto* channel : {&block.red, &block.green, &block.blue}) {
      (*channel)[v] = random() % 4 == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(random());
    }
  }
}

constexpr float kNoLimit = std::numeric_limits<float>::infinity();

struct PlainVoxel {
  double distance = 0;
  double weight = 0;
  double red = 0;
  int label = 0;
  double label_weight = 0;
  double votes = 0;
};

PlainVoxel voxel_of(const BlockPlanes& b, std::size_t v) {
  return {b.distance[v], b.weight[v], static_cast<double>(b.red[v]), b.label[v], b.label_weight[v], b.vote_sum[v]};
}

// The rules of the header, word by word.
PlainVoxel naive(const PlainVoxel& a, const PlainVoxel& b) {
  PlainVoxel m = a;
  m.weight = a.weight + b.weight;
  if (m.weight > 0) m.distance = (a.weight * a.distance + b.weight * b.distance) / m.weight;
  if (b.weight > 0) {
    if (a.red > 0 && b.red > 0) m.red = std::floor((a.weight * a.red + b.weight * b.red) / m.weight + 0.5);
    if (a.red == 0) m.red = b.red;
  }
  const bool agree = a.label == b.label;
  m.label_weight = agree ? a.label_weight + b.label_weight : std::abs(a.label_weight - b.label_weight);
  m.votes = a.votes + b.votes;
  m.label = !agree && b.label_weight > a.label_weight ? b.label : a.label;
  return m;
}

TEST(MapMerge, FusesVoxelsByTheirWeights) {
  std::mt19937 random(5);
  std::vector<std::uint16_t> same(kLabelSlots);
  std::iota(same.begin(), same.end(), std::uint16_t{0});
  for (int round = 0; round < 5; ++round) {
    BlockPlanes a;
    BlockPlanes b;
    fill(a, random);
    fill(b, random);
    BlockPlanes both = a;
    BlockPlanes other_way = b;
    merge_block(b, same, kNoLimit, both);
    merge_block(a, same, kNoLimit, other_way);
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      const PlainVoxel expected = naive(voxel_of(a, v), voxel_of(b, v));
      ASSERT_EQ(both.distance[v], static_cast<float>(expected.distance));
      ASSERT_EQ(both.weight[v], static_cast<float>(expected.weight));
      ASSERT_EQ(both.red[v], expected.red);
      ASSERT_EQ(both.label[v], expected.label);
      ASSERT_EQ(both.label_weight[v], static_cast<float>(expected.label_weight));
      ASSERT_EQ(both.vote_sum[v], static_cast<float>(expected.votes));
    }
    EXPECT_EQ(both.distance, other_way.distance);
    EXPECT_EQ(both.weight, other_way.weight);
    EXPECT_EQ(both.red, other_way.red);
    EXPECT_EQ(both.green, other_way.green);
    EXPECT_EQ(both.blue, other_way.blue);
    EXPECT_EQ(both.label_weight, other_way.label_weight);
    EXPECT_EQ(both.vote_sum, other_way.vote_sum);
  }
}

TEST(MapMerge, SumsStopAtTheLimitAndVotesKeepWhatTheySay) {
  constexpr float kLimit = 10;
  std::mt19937 random(6);
  std::vector<std::uint16_t> same(kLabelSlots);
  std::iota(same.begin(), same.end(), std::uint16_t{0});
  BlockPlanes a;
  BlockPlanes b;
  fill(a, random);
  fill(b, random);
  BlockPlanes both = a;
  merge_block(b, same, kLimit, both);
  BlockPlanes unlimited = a;
  merge_block(b, same, kNoLimit, unlimited);
  int limited = 0;
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    ASSERT_EQ(both.weight[v], std::min(kLimit, unlimited.weight[v]));
    ASSERT_EQ(both.vote_sum[v], std::min(kLimit, unlimited.vote_sum[v]));
    ASSERT_EQ(both.distance[v], unlimited.distance[v]);
    ASSERT_EQ(both.label[v], unlimited.label[v]);
    ASSERT_LE(both.label_weight[v], both.vote_sum[v]);
    if (both.vote_sum[v] == unlimited.vote_sum[v]) {
      ASSERT_EQ(both.label_weight[v], unlimited.label_weight[v]);
      continue;
    }
    ++limited;
    ASSERT_NEAR(both.label_weight[v] / both.vote_sum[v], unlimited.label_weight[v] / unlimited.vote_sum[v], 1e-6);
  }
  EXPECT_GT(limited, 100);
}

TEST(MapMerge, TheMergedMapHasTheLowerLimitOfBoth) {
  const auto limit_of = [](float a, float b) {
    MapWithFrames first = world({kLeft});
    MapWithFrames second = world({kRight});
    first.saved.options.max_weight = a;
    second.saved.options.max_weight = b;
    return merged(std::move(first), second).merged.saved.options.max_weight;
  };
  EXPECT_EQ(limit_of(100, 30), 30);
  EXPECT_EQ(limit_of(30, 100), 30);
  EXPECT_EQ(limit_of(0, 30), 30) << "0 is no limit";
  EXPECT_EQ(limit_of(30, 0), 30);
  EXPECT_EQ(limit_of(0, 0), 0);
}

TEST(MapMerge, WithItselfKeepsTheSurfaceAndTheObjectsAndAddsTheirEvidence) {
  const auto make = [] { return world({kLeft, kRight, kMiddle}); };
  const MapWithFrames alone = make();
  const MapMerge merge = merged(make(), alone);
  const SavedMap& both = merge.merged.saved;
  ASSERT_EQ(both.map.voxels.block_count(), alone.saved.map.voxels.block_count());
  for (Slot slot = 0; slot < both.map.voxels.block_count(); ++slot) {
    ASSERT_EQ(test::planes_of(both.map.voxels.block(slot)).distance,
              test::planes_of(alone.saved.map.voxels.block(slot)).distance);
    ASSERT_EQ(test::planes_of(both.map.voxels.block(slot)).label, test::planes_of(alone.saved.map.voxels.block(slot)).label);
    for (int v = 0; v < kBlockVoxels; ++v) {
      ASSERT_EQ(both.map.voxels.block(slot).weight(v), 2 * alone.saved.map.voxels.block(slot).weight(v));
    }
  }
  EXPECT_EQ(both.map.objects.count(), 3U);
  EXPECT_EQ(both.map.objects.find(pid(4))->observations, 20U);
  EXPECT_EQ(both.map.objects.find(pid(4))->score_sum, 10);
  EXPECT_EQ(both.map.objects.class_of(pid(6)), kTable);
}

TEST(MapMerge, FindsObjectsAgainThatHaveOtherIdsAndGivesNewOnesToTheOthers) {
  const MapWithFrames b = world({kMiddle, kRight});
  const MapMerge merge = merged(world({kLeft, kMiddle}), b);
  ASSERT_EQ(merge.matches.size(), 1U);
  EXPECT_EQ(merge.matches[0].a, PanopticId{5});
  EXPECT_EQ(merge.matches[0].b, PanopticId{4});
  EXPECT_GT(merge.matches[0].iou, 0.85);
  const SavedMap& both = merge.merged.saved;
  EXPECT_EQ(both.map.objects.count(), 3U);
  EXPECT_EQ(both.map.objects.class_of(pid(6)), kChair) << "the one on the right";
  const LabelExtents before = label_extents(b.saved.map.voxels);
  const LabelExtents after = label_extents(both.map.voxels);
  EXPECT_GT(after.at(pid(6)).voxels, before.at(pid(5)).voxels * 6 / 10) << "but where A has the floor";
}

TEST(MapMerge, AnObjectOfWhichEachMapSawAHalfIsOne) {
  const Thing kLong{{-0.5, -0.1, 0}, {0.5, 0.1, 0.2}, kTable};
  const MapWithFrames right = world({kLong}, Vec3d(-0.1, kFrom, kFrom));
  const MapMerge merge = merged(world({kLong}, Vec3d::Constant(kFrom), Vec3d(0.1, kTo, kTo)), right);
  EXPECT_EQ(merge.merged.saved.map.objects.count(), 1U);
  const auto box = box_of(label_extents(merge.merged.saved.map.voxels).at(pid(4)), merge.merged.saved.map.voxels.voxel_size_m());
  EXPECT_NEAR(box.max_m.x() - box.min_m.x(), 1.0, 0.1);
  EXPECT_NEAR(box.center_m.x(), 0, 0.02);
}

TEST(MapMerge, ASmallPieceIsAPartOfTheWholeInTheOtherMap) {
  const Thing whole{{-0.3, -0.3, 0}, {0.3, 0.3, 0.2}, kTable};
  const Thing most{{-0.3, -0.3, 0}, {0.3, 0.2, 0.2}, kTable};
  const Thing piece{{-0.3, 0.2, 0}, {0.3, 0.3, 0.2}, kTable};
  for (const bool whole_first : {true, false}) {
    const auto in_one = [&] { return world({whole}); };
    const auto in_two = [&] { return world({most, piece}); };
    const MapMerge merge = whole_first ? merged(in_one(), in_two()) : merged(in_two(), in_one());
    ASSERT_EQ(merge.merged.saved.map.objects.count(), 1U) << whole_first;
    EXPECT_EQ(merge.merged.saved.map.objects.find(pid(4))->observations, 30U);
    EXPECT_FALSE(label_extents(merge.merged.saved.map.voxels).contains(pid(5)));
  }
}

TEST(MapMerge, TwoThingsThatTheOtherMapTookForOneStayTwo) {
  const Thing both{{-0.3, -0.3, 0}, {0.3, 0.3, 0.2}, kChair};
  const Thing one{{-0.3, -0.3, 0}, {0.3, 0, 0.2}, kChair};
  const Thing other{{-0.3, 0, 0}, {0.3, 0.3, 0.2}, kChair};
  EXPECT_EQ(merged(world({one, other}), world({both})).merged.saved.map.objects.count(), 2U);
}

TEST(MapMerge, AnotherClassNeedsTwiceTheOverlap) {
  Thing chair = kMiddle;
  chair.class_id = kChair;
  EXPECT_EQ(merged(world({kMiddle}), world({chair})).matches.size(), 1U) << "in the same place";
  const auto in_three = [](ClassId class_of_first) {
    return world({{{-0.1, -0.1, 0}, {-0.02, 0.1, 0.4}, class_of_first},
                  {{-0.02, -0.1, 0}, {0.04, 0.1, 0.4}, kChair},
                  {{0.04, -0.1, 0}, {0.1, 0.1, 0.4}, kChair}});
  };
  const MapWithFrames one_table = in_three(kTable);
  const std::vector<ObjectMatch> same = merged(world({kMiddle}), one_table).matches;
  ASSERT_EQ(same.size(), 1U);
  EXPECT_EQ(same[0].b, PanopticId{4});
  EXPECT_LT(same[0].iou, 0.5);
  EXPECT_EQ(merged(world({kMiddle}), in_three(kChair)).matches.size(), 0U);
}

TEST(MapMerge, FramesOfTheSecondMapFollowThoseOfTheFirst) {
  const MapMerge merge = merged(world({kLeft, kMiddle}), world({kMiddle, kRight}));
  ASSERT_EQ(merge.merged.frames.size(), 40U);
  EXPECT_GE(merge.frame_shift, 20);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(merge.merged.frames[i].position, static_cast<std::int64_t>(i));
  EXPECT_EQ(merge.merged.frames[20].frame, merge.frame_shift);
  const Object& right = *merge.merged.saved.map.objects.find(pid(6));
  EXPECT_EQ(right.first_frame, 10 + merge.frame_shift);
  EXPECT_EQ(right.best_views.views()[0].frame, 10 + merge.frame_shift);
  const VoteHistory& votes = right.votes;
  EXPECT_LE(votes.first_frame(votes.bins().front()), 10 + merge.frame_shift);
  const Object& middle = *merge.merged.saved.map.objects.find(pid(5));
  EXPECT_EQ(middle.first_frame, 10);
  EXPECT_EQ(middle.last_frame, 9 + merge.frame_shift);
  std::uint64_t all = 0;
  for (const VoteHistory::Bin& bin : middle.votes.bins()) all += bin.votes.at(kTable);
  EXPECT_EQ(all, 20U);
}

TEST(MapMerge, IsTheSameAtAnyThreadCountAndCanBeSavedAndLoaded) {
  std::uint64_t hashes[2];
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    const MapMerge merge = merged(world({kLeft, kMiddle}), world({kMiddle, kRight}));
    hashes[threads == 1 ? 0 : 1] = merge.merged.saved.map.voxels.hash();
    const auto path = test::fresh_folder() / "c.panoptic";
    const SavedMap& saved = merge.merged.saved;
    MapUpdate update = whole_map(saved.map);
    update.frames = merge.merged.frames;
    save_map(path, saved.header(), update);
    const SavedMap loaded = load_map(path);
    EXPECT_EQ(loaded.map.voxels.hash(), saved.map.voxels.hash());
    EXPECT_EQ(loaded.map.objects.state(), saved.map.objects.state());
  }
  set_thread_count(0);
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(MapMerge, RefusesMapsThatDoNotFit) {
  const auto refusal = [](const std::function<void(MapWithFrames&)>& change) {
    MapWithFrames a = world({kMiddle});
    MapWithFrames b = world({kMiddle});
    change(b);
    return error_of([&] { (void)merged(std::move(a), b); });
  };
  EXPECT_THAT(refusal([](MapWithFrames& b) { b.saved.options.voxel_size_m = 0.05F; }), HasSubstr("voxels of 0.024 m, B of"));
  EXPECT_THAT(refusal([](MapWithFrames& b) { b.saved.options.truncation_voxels = 3; }), HasSubstr("truncation of 4 voxels"));
  EXPECT_THAT(refusal([](MapWithFrames& b) {
                b.saved.map.labels = LabelSet("other", {{kFloor, "floor", false, {}}});
              }),
              HasSubstr("label set 'test', B has 'other'"));
  EXPECT_THAT(refusal([](MapWithFrames& b) { b.frames.push_back({.frame = std::int64_t{1} << 60}); }),
              HasSubstr("B has frame numbers"));
}

// Those of the first map stay; those of the second one get new ones, which count up, whatever they were.
TEST(MapMerge, IdsOfTheFirstMapStayAndThoseOfTheSecondCountUp) {
  const auto renumbered = [](MapWithFrames map, std::uint32_t first_id) {
    RegistryState state = map.saved.map.objects.state();
    for (Object& object : state.objects) object.id = static_cast<PanopticId>(number(object.slot) + first_id);
    state.next_id = PanopticId{first_id + 1000};
    map.saved.map.objects = ObjectRegistry(kFirst, std::move(state));
    return map;
  };
  const MapMerge merge = merged(renumbered(world({kLeft, kMiddle}), 100'000), renumbered(world({kMiddle, kRight}), 700));
  const ObjectRegistry& objects = merge.merged.saved.map.objects;
  ASSERT_EQ(objects.count(), 3U);
  EXPECT_NE(objects.find(PanopticId{100'000 + kFirst}), nullptr);
  EXPECT_NE(objects.find(PanopticId{100'001 + kFirst}), nullptr);
  EXPECT_EQ(objects.find(PanopticId{101'000})->slot, LabelSlot{kFirst + 2});
  EXPECT_EQ(objects.next_id(), PanopticId{101'001});
  ASSERT_EQ(merge.matches.size(), 1U);
  EXPECT_EQ(merge.matches[0].a, PanopticId{100'001 + kFirst});
  EXPECT_EQ(merge.matches[0].b, PanopticId{700 + kFirst});
}

TEST(MapMerge, RunsOutOfIdsInOneLine) {
  const auto crowd = [] {
    MapWithFrames map = world({kMiddle});
    RegistryState state = map.saved.map.objects.state();
    while (state.objects.size() < 40000) {
      Object& object = state.objects.emplace_back();
      object.slot = static_cast<LabelSlot>(kFirst + state.objects.size() - 1);
      object.id = PanopticId{number(object.slot)};
    }
    state.next_id = PanopticId{40000 + kFirst};
    map.saved.map.objects = ObjectRegistry(kFirst, std::move(state));
    return map;
  };
  EXPECT_THAT(error_of([&] { (void)merged(crowd(), crowd()); }), HasSubstr("more objects together than there are ids"));
}

}  // namespace
}  // namespace panoptic
