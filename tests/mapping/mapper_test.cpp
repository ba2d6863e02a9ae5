// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapper.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/profile.h"

#include <gtest/gtest.h>

#include <malloc.h>

#include <algorithm>
#include <limits>

#include "panoptic/base/config.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/parallel.h"
#include "tests/block_planes.h"
#include "tests/mapping/ball_on_floor.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

using test::halves;
using test::look_at;
using test::render;
using test::segmented;
using test::small_camera;
using test::Surface;

Frame orbit_frame(int i) {
  const Surface scene = test::ball_on_floor();
  const double angle = 0.05 * i;
  return render(scene, small_camera(), look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), i);
}

TEST(Mapper, ABallOnAFloorIsOneChairOnAFloorFromAllSides) {
  Mapper mapper({}, test::test_labels());
  for (int i = 0; i < 120; i += 4) {
    const Frame frame = orbit_frame(i);
    ASSERT_EQ(mapper.add(frame, segmented(frame)), Outcome{});
  }
  ASSERT_EQ(mapper.map().objects.count(), 1U) << "one object, re-identified in every frame";
  EXPECT_EQ(mapper.map().objects.find(LabelSlot{4})->observations, 30U);
  const Mesh mesh = mapper.mesh();
  int right = 0;
  for (const MeshVertex& v : mesh.vertices) {
    const bool on_floor = v.position.y() > 0.55F;
    right += v.class_id == (on_floor ? ClassId{2} : ClassId{3}) ? 1 : 0;
  }
  EXPECT_GT(right, static_cast<int>(mesh.vertices.size()) * 95 / 100);
  EXPECT_GT(mapper.up().dot(-Vec3d::UnitY()), 0.8);
}

TEST(Mapper, TheSameFramesGiveTheSameMapAtAnyThreadCount) {
  std::uint64_t hashes[3];
  for (const std::size_t k : {0U, 1U, 2U}) {
    set_thread_count(static_cast<int>(k) * 2 + 1);
    Mapper mapper({}, test::test_labels());
    for (int i = 0; i < 40; i += 4) ASSERT_TRUE(mapper.add(orbit_frame(i), halves(small_camera())).used);
    hashes[k] = mapper.map().voxels.hash();
  }
  set_thread_count(0);
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(Mapper, WithoutAPredictionThereIsNoObjectAndNoLabel) {
  Mapper mapper({}, test::test_labels());
  for (int i = 0; i < 60; ++i) ASSERT_EQ(mapper.add(orbit_frame(i), {}), Outcome{});
  mapper.finish();
  EXPECT_EQ(mapper.map().objects.count(), 0U);
  const std::vector<bool> labels = ids_in_use(mapper.map().voxels);
  EXPECT_EQ(std::count(labels.begin() + 1, labels.end(), true), 0);
}

TEST(Mapper, AFrameWithoutAPredictionAddsGeometryOnly) {
  Mapper mapper({}, test::test_labels());
  ASSERT_EQ(mapper.add(orbit_frame(0), {}), Outcome{});
  EXPECT_EQ(mapper.map().objects.count(), 0U);
  for (const MeshVertex& v : mapper.mesh().vertices) ASSERT_EQ(v.panoptic_id, PanopticId::kUnknown);
}

// Labels as by `segmented`, but a tenth of the pixels says something else.
Segmentation noisy(const Frame& frame) {
  Segmentation s = segmented(frame);
  std::uint32_t state = static_cast<std::uint32_t>(frame.index) * 747796405U + 1;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      state = state * 1664525U + 1013904223U;
      if (state >> 24 < 26) s.segment_at(u, v) = static_cast<std::uint16_t>(state >> 8 & 1);
    }
  }
  return s;
}

TEST(Mapper, RegularizesEverySoManyFramesAndWhenAsked) {
  Options options;
  options.regularizer.every_frames = 4;
  Mapper mapper(options, test::test_labels());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(mapper.add(orbit_frame(i), noisy(orbit_frame(i))).used);
  EXPECT_EQ(mapper.profile().stages().at("regularize").count(), 2U);
  mapper.regularize();
  EXPECT_EQ(mapper.profile().stages().at("regularize").count(), 3U);

  options.regularizer.enabled = false;
  Mapper without(options, test::test_labels());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(without.add(orbit_frame(i), noisy(orbit_frame(i))).used);
  const std::uint64_t hash = without.map().voxels.hash();
  without.regularize();
  EXPECT_EQ(without.map().voxels.hash(), hash);
  EXPECT_EQ(without.profile().stages().count("regularize"), 0U);
}

// Labels, tracking, regularizer and object maintenance, in every build. If a deliberate change of the arithmetic moves this
// number, say so in the changelog.
TEST(Mapper, TheWholeMapIsGoldenAtAnyThreadCount) {
  constexpr std::uint64_t kGolden = 7125777576978412439ULL;
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    Options options;
    options.regularizer.every_frames = 3;
    Mapper mapper(options, test::test_labels());
    for (int i = 0; i < 40; i += 4) ASSERT_TRUE(mapper.add(orbit_frame(i), noisy(orbit_frame(i))).used);
    mapper.finish();
    EXPECT_EQ(mapper.map().voxels.hash(), kGolden) << threads << " threads";
  }
  set_thread_count(0);
}

TEST(Mapper, ObjectsThatTheRegularizerTakesTheLastVoxelOfAreForgotten) {
  Options options;
  options.regularizer.w1 = 10;
  options.regularizer.w2 = 15;
  options.regularizer.band_voxels = 4;
  Mapper mapper(options, test::test_labels());
  for (int i = 0; i < 40; i += 4) {
    const Frame frame = orbit_frame(i);
    Segmentation s = segmented(frame);
    if (i == 4) {  // a speck on the floor, seen once
      s.segments.push_back({ClassId{3}, 0.9F, {}});
      s.segment_at(5, 100) = s.segment_at(6, 100) = 3;
    }
    ASSERT_EQ(mapper.add(frame, s), Outcome{});
  }
  mapper.regularize();
  mapper.parts().forget_votes_without_voxels();  // until then it could come back
  const std::vector<bool> used = ids_in_use(mapper.map().voxels);
  std::size_t alive = 0;
  for (std::size_t id = mapper.map().labels.first_thing(); id < used.size(); ++id) {
    const bool known = mapper.map().objects.find(static_cast<LabelSlot>(id)) != nullptr;
    EXPECT_EQ(known, used[id]) << id;
    alive += known ? 1 : 0;
  }
  EXPECT_GE(alive, 1U);
}

// A floor of 48 x 48 voxels that frames say is `object`, with a few voxels that say floor, unsurely.
VoxelMap floor_of(LabelSlot object) {
  VoxelMap map({});
  for (int z = -2; z < 2; ++z) {
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 48; ++x) {
        VoxelBlock& block = map.block(map.allocate({x >> 4, y >> 4, z >> 4}));
        const bool unsure = x % 12 == 6 && y % 12 == 6;
        block.set(voxel_offset(x & 15, y & 15, z & 15), {.distance = (static_cast<float>(z) + 0.5F) * map.voxel_size_m(),
                                                         .weight = 10,
                                                         .label_weight = unsure ? 1.0F : 8.0F,
                                                         .vote_sum = 10,
                                                         .label = unsure ? std::uint16_t{2} : number(object)});
      }
    }
  }
  return map;
}

TEST(Mapper, WhatWasSolvedBeforeAMergeIsWrittenAboutWhatTheObjectsAreNow) {
  ObjectRegistry objects(test::test_labels().first_thing());
  const LabelSlot chair = *objects.create();
  const LabelSlot same_chair = *objects.create();
  Mapper mapper({}, test::test_labels());
  mapper.parts().restore({test::test_labels(), floor_of(chair), objects}, {});
  const auto tiles = mapper.parts().choose_tiles();
  ASSERT_EQ(tiles.size(), 1U);
  const TileChanges changes = mapper.parts().solve(mapper.parts().gather(tiles[0]));
  ASSERT_GE(changes.changes.size(), 16U);
  ASSERT_EQ(changes.changes[0].label.label, number(chair));

  ObjectRegistry merged = objects;
  merged.merge(chair, same_chair, 1);
  mapper.parts().restore({test::test_labels(), floor_of(same_chair), merged}, {});
  mapper.parts().write_back(changes);
  std::size_t written = 0;
  for (const LabelChange& change : changes.changes) {
    const BlockPlanes block = test::planes_of(mapper.map().voxels.block(change.before.slot));
    written += block.label[change.before.voxel] == number(same_chair) ? 1 : 0;
  }
  EXPECT_EQ(written, changes.changes.size());
  EXPECT_FALSE(ids_in_use(mapper.map().voxels)[number(chair)]);
  for (const auto& of_block : mapper.parts().state().regularizer.votes) {
    for (const OverruledVote& vote : of_block) {
      EXPECT_EQ(vote.voted.label, 2) << "what frames voted for";
      EXPECT_EQ(vote.written.label, number(same_chair));
    }
  }

  ObjectRegistry none = objects;
  none.retire_unused(std::vector<bool>(kLabelSlots, false));
  mapper.parts().restore({test::test_labels(), floor_of(LabelSlot{2}), none}, {});
  const std::uint64_t hash = mapper.map().voxels.hash();
  mapper.parts().write_back(changes);
  EXPECT_EQ(mapper.map().voxels.hash(), hash) << "the object is no more";
}

TEST(Mapper, VotesForAMergedObjectAreForTheOneThatItIsNow) {
  ObjectRegistry objects(test::test_labels().first_thing());
  const LabelSlot chair = *objects.create();
  const LabelSlot same_chair = *objects.create();
  Mapper mapper({}, test::test_labels());
  mapper.parts().restore({test::test_labels(), floor_of(chair), objects}, {});
  TileChanges changes = mapper.parts().solve(mapper.parts().gather(mapper.parts().choose_tiles()[0]));
  for (LabelChange& change : changes.changes) change.before.voted.label = number(chair);  // as if frames had voted for it
  for (LabelChange& change : changes.changes) change.label.label = number(ClassId{1});
  ObjectRegistry merged = objects;
  merged.merge(chair, same_chair, 1);
  mapper.parts().restore({test::test_labels(), floor_of(same_chair), merged}, {});
  mapper.parts().write_back(changes);
  std::size_t votes = 0;
  for (const auto& of_block : mapper.parts().state().regularizer.votes) {
    for (const OverruledVote& vote : of_block) {
      ++votes;
      EXPECT_EQ(vote.voted.label, number(same_chair));
    }
  }
  EXPECT_EQ(votes, changes.changes.size());
}

// A small frame whose detections never find a hold: every pixel is a segment of its own, seen once and outvoted at once.
Frame tiny_frame() {
  const Camera camera{16, 12, 14, 14, 8, 6};
  return render(test::plane(Vec3d::UnitZ(), 1), camera, Pose::Identity());
}

Segmentation checkered(const Frame& frame, int step) {
  Segmentation s{Image<std::uint16_t>(frame.color.width(), frame.color.height()), {{ClassId{1}, 1, {}}}};
  for (std::size_t i = 0; i < s.segment_at.size(); ++i) {
    const bool thing = i % 7 == static_cast<std::size_t>(step) % 7;
    if (thing) s.segments.push_back({ClassId{3}, 0.5F, {}});
    s.segment_at[i] = static_cast<std::uint16_t>(thing ? s.segments.size() : 1);
  }
  return s;
}

double allocated_mb() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

// A run of a million frames must not grow with frames: after the place is mapped, nothing that a mapper holds gets larger.
TEST(Mapper, MemoryDoesNotGrowWithFrames) {
  if (test::kSanitized) GTEST_SKIP() << "sanitizers replace the allocator that is asked here";
  set_thread_count(1);
  Mapper mapper({}, test::test_labels());
  const Frame frame = tiny_frame();
  Frame bad = frame;
  bad.world_from_camera.translation().x() = std::numeric_limits<double>::quiet_NaN();
  const auto add_many = [&](int count) {
    for (int i = 0; i < count; ++i) {
      ASSERT_EQ(mapper.add(frame, checkered(frame, i)), Outcome{});
      ASSERT_FALSE(mapper.add(bad, {}).used);
    }
  };
  add_many(3000);  // about 80,000 objects: more than there are ids
  const double settled_mb = allocated_mb();
  add_many(3000);
  EXPECT_LT(allocated_mb() - settled_mb, 0.025) << "8 bytes a frame";
  EXPECT_LT(mapper.map().objects.count(), 4096U);
  EXPECT_LE(mapper.frames().first_skipped().size(), FrameStatistics::kMaxListed);
  // And new things are still found.
  Segmentation whole{Image<std::uint16_t>(16, 12, 1), {{ClassId{3}, 1, {}}}};
  for (int i = 0; i < 10000; ++i) ASSERT_EQ(mapper.add(frame, whole), Outcome{});
  const Mesh mesh = mapper.mesh();
  const auto is_chair = [](const MeshVertex& v) { return v.class_id == ClassId{3}; };
  EXPECT_GT(std::count_if(mesh.vertices.begin(), mesh.vertices.end(), is_chair), 10);
  set_thread_count(0);
}

// Seconds of ten frames' fusion that no stage tells of.
double untold_seconds() {
  Mapper mapper({}, test::test_labels());
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(mapper.add(orbit_frame(i), halves(small_camera())).used);
  const auto& stages = mapper.profile().stages();
  double untold_s = stages.at("fusion").total_s();
  for (const char* stage : {"register", "moving", "reference", "track", "integrate", "free space"}) {
    EXPECT_EQ(stages.at(stage).count(), 10U) << stage;
    untold_s -= stages.at(stage).total_s();
  }
  return untold_s;
}

// A busy machine takes the processor away between two stages, but not every time.
TEST(Mapper, StagesAddUpToFusion) {
  double least_s = untold_seconds();
  for (int tries = 0; least_s > 0.001 && tries < 20; ++tries) least_s = std::min(least_s, untold_seconds());
  EXPECT_GT(least_s, -0.001);
  EXPECT_LT(least_s, 0.001);
}

TEST(Options, RoundTripThroughToml) {
  Options a;
  a.labels = "scannet20";
  a.map.voxel_size_m = 0.0125F;
  a.integrator.method = "raycast";
  Options b;
  read_toml_text(to_toml(fields(a)), "round trip", fields(b));
  EXPECT_EQ(to_toml(fields(a)), to_toml(fields(b)));
  EXPECT_EQ(b.map.voxel_size_m, 0.0125F);
}

TEST(Options, DefaultsAreThePapers) {
  const Options o;
  EXPECT_FLOAT_EQ(o.map.voxel_size_m, 0.024F);
  EXPECT_FLOAT_EQ(o.map.truncation_voxels, 4);
  EXPECT_FLOAT_EQ(o.tracker.iou_threshold, 0.25F);
}

}  // namespace
}  // namespace panoptic
