// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/publisher.h"
#include "panoptic/mapping/mapper_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/mapping/ball_on_floor.h"

namespace panoptic {
namespace {

using test::look_at;
using test::render;
using test::segmented;
using test::small_camera;

Frame orbit_frame(int i) {
  const test::Surface scene = test::ball_on_floor();
  const double angle = 0.05 * i;
  Frame frame = render(scene, small_camera(), look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), i);
  frame.time_s = i / 30.0;
  frame.color_from_depth.translation() = Vec3d(0.03, 0, 0);
  return frame;
}

struct PublishedRun {
  Mapper mapper{{}, test::test_labels()};
  LatestSnapshot latest;
  SnapshotPublisher publisher{latest};

  void add(int i, bool with_labels) {
    const auto frame = std::make_shared<const Frame>(orbit_frame(i));
    const auto segmentation = std::make_shared<const Segmentation>(with_labels ? segmented(*frame) : Segmentation());
    ASSERT_EQ(mapper.add(*frame, *segmentation), Outcome{});
    publisher.fused(frame);
    if (with_labels) publisher.labelled({frame, segmentation, mapper.segment_ids()});
  }
  std::shared_ptr<const Snapshot> publish() {
    publisher.publish(publisher.capture(mapper, {}));
    return latest.newest();
  }
};

TEST(SnapshotPublisher, AnEmptySessionGivesAnEmptySnapshot) {
  PublishedRun run;
  EXPECT_EQ(run.latest.newest()->revision, 0U);
  const auto snapshot = run.publish();
  EXPECT_EQ(snapshot->revision, 1U);
  EXPECT_TRUE(snapshot->chunks.empty());
  EXPECT_TRUE(snapshot->objects.empty());
  EXPECT_TRUE(snapshot->path_m.empty());
  EXPECT_EQ(snapshot->frame.index, -1);
  EXPECT_EQ(snapshot->frame.color, nullptr);
}

TEST(SnapshotPublisher, ChunksHoldTheSurfaceOfTheMeshAndStayTheSameUntilTheyChange) {
  PublishedRun run;
  for (int i = 0; i < 6; ++i) run.add(i, true);
  const auto first = run.publish();
  const auto again = run.publish();
  run.add(9, true);
  const auto later = run.publish();
  std::size_t triangles = 0;
  std::size_t unchanged = 0;
  for (std::size_t i = 0; i < first->chunks.size(); ++i) {
    const SnapshotChunk& chunk = first->chunks[i];
    EXPECT_EQ(chunk.index, run.mapper.map().voxels.index_of(static_cast<Slot>(i)));
    EXPECT_EQ(chunk.version, 1U);
    EXPECT_EQ(again->chunks[i].version, 1U);
    EXPECT_EQ(again->chunks[i].surface, chunk.surface) << "shared, not copied";
    EXPECT_EQ(later->chunks[i].index, chunk.index) << "a chunk keeps its place";
    const bool same = later->chunks[i].surface == chunk.surface;
    EXPECT_EQ(later->chunks[i].version, same ? 1U : 3U);
    unchanged += same ? 1 : 0;
  }
  EXPECT_GT(unchanged, 0U);
  EXPECT_LT(unchanged, first->chunks.size());
  for (const SnapshotChunk& chunk : later->chunks) triangles += chunk.surface->triangles.size();
  EXPECT_EQ(triangles, run.mapper.mesh().triangles.size());
}

TEST(SnapshotPublisher, ASnapshotStaysAsItWasWhileTheMapGrows) {
  PublishedRun run;
  for (int i = 0; i < 3; ++i) run.add(i, true);
  const auto held = run.publish();
  const auto vertices_of = [](const Snapshot& s) {
    std::vector<Vec3f> all;
    for (const auto& c : s.chunks) {
      for (const ChunkVertex& v : c.surface->vertices) all.push_back(v.position);
    }
    return all;
  };
  const std::vector<Vec3f> before = vertices_of(*held);
  for (int i = 3; i < 20; i += 4) run.add(i, true);
  run.publish();
  EXPECT_EQ(vertices_of(*held), before);
}

TEST(SnapshotPublisher, ObjectsHaveClassProbabilitiesAndTheBoxOfTheirVertices) {
  PublishedRun run;
  for (int i = 0; i < 30; i += 3) run.add(i, true);
  const auto snapshot = run.publish();
  ASSERT_EQ(snapshot->objects.size(), 1U);
  const SnapshotObject& ball = snapshot->objects[0];
  EXPECT_EQ(ball.class_id, ClassId{3});
  EXPECT_EQ(ball.observations, 10U);
  EXPECT_EQ(ball.first_frame, 0);
  EXPECT_EQ(ball.last_frame, 27);
  ASSERT_EQ(ball.probabilities.size(), 1U);
  EXPECT_FLOAT_EQ(ball.probabilities[0].probability, 1);
  std::uint64_t vertices = 0;
  Vec3f min_m = Vec3f::Constant(1e9F);
  Vec3f max_m = Vec3f::Constant(-1e9F);
  for (const auto& chunk : snapshot->chunks) {
    for (const ChunkVertex& v : chunk.surface->vertices) {
      if (v.panoptic_id != ball.id) continue;
      ++vertices;
      min_m = min_m.cwiseMin(v.position);
      max_m = max_m.cwiseMax(v.position);
    }
  }
  EXPECT_EQ(ball.vertices, vertices);
  EXPECT_EQ(ball.min_m, min_m);
  EXPECT_EQ(ball.max_m, max_m);
}

TEST(SnapshotPublisher, TheNewestLabelledFrameMayBeOlderThanTheNewestFrame) {
  PublishedRun run;
  run.add(0, true);
  run.add(1, false);
  const auto snapshot = run.publish();
  const SnapshotFrame& frame = snapshot->frame;
  EXPECT_EQ(frame.index, 1);
  EXPECT_DOUBLE_EQ(frame.time_s, 1 / 30.0);
  EXPECT_EQ(*frame.color, orbit_frame(1).color);
  EXPECT_TRUE(frame.world_from_color.isApprox(orbit_frame(1).world_from_camera * orbit_frame(1).color_from_depth.inverse()));
  EXPECT_EQ(frame.labelled_index, 0);
  EXPECT_EQ(*frame.labelled_color, orbit_frame(0).color);
  const Segmentation truth = segmented(orbit_frame(0));
  for (std::size_t i = 0; i < truth.segment_at.size(); ++i) {
    ASSERT_EQ((*frame.labelled_ids)[i], truth.segment_at[i] == 2 ? PanopticId{2} : PanopticId{4}) << "floor, or the first object";
  }
  EXPECT_EQ(snapshot->run.frames_used, 2U);
  EXPECT_EQ(snapshot->run.frames_labelled, 1U);
  EXPECT_EQ(snapshot->run.stages.at("fusion").count, 2U);
  EXPECT_GT(snapshot->run.memory_mb, 1);
}

TEST(SnapshotPublisher, ConfidenceIsTheShareOfTheNearerVoxelsWeightThatSpeaksForTheLabel) {
  Options options;
  options.integrator.object_vote = 1;
  Mapper mapper(options, test::test_labels());
  for (int i = 0; i < 4; ++i) {
    Segmentation says = segmented(orbit_frame(i));
    if (i == 3) says.segment_at = Image<std::uint16_t>(says.segment_at.width(), says.segment_at.height());
    ASSERT_TRUE(mapper.add(orbit_frame(i), says).used);
  }
  std::size_t all = 0;
  std::size_t between = 0;
  std::size_t wrong = 0;
  for (const auto& chunk : mapper.parts().surface()) {
    for (const ChunkVertex& v : chunk->vertices) {
      const Vec3f voxel = v.position / mapper.map().voxels.voxel_size_m();
      const auto x = static_cast<int>(std::floor(voxel.x()));
      const auto y = static_cast<int>(std::floor(voxel.y()));
      const auto z = static_cast<int>(std::floor(voxel.z()));
      const VoxelBlock* block = mapper.map().voxels.find({x >> 4, y >> 4, z >> 4});
      ASSERT_NE(block, nullptr);
      const int i = voxel_offset(x & 15, y & 15, z & 15);
      const float share = label_share(block->label_weight(i), block->vote_sum(i));
      ++all;
      between += v.confidence > 20 && v.confidence < 235 ? 1 : 0;
      wrong += std::abs(static_cast<float>(v.confidence) - share * 255) > 0.51F ? 1 : 0;
    }
  }
  EXPECT_GT(between, all / 4);
  EXPECT_LT(wrong, all / 1000) << "vertices in the middle between two voxels, where rounding decides which is nearer";
}

TEST(CameraPath, IsThinnedEvenlyAndEndsAtTheNewestPlace) {
  CameraPath path;
  constexpr int kPlaces = 150001;
  for (int i = 0; i < kPlaces; ++i) {
    path.add(Vec3f(static_cast<float>(i), 0, 0));
    ASSERT_TRUE(i % 9973 != 0 || path.points().size() <= kMaxPathPoints);
  }
  const std::vector<Vec3f> points = path.points();
  ASSERT_LE(points.size(), kMaxPathPoints);
  ASSERT_GT(points.size(), kMaxPathPoints / 3);
  EXPECT_EQ(points.back().x(), kPlaces - 1);
  const float step = points[1].x() - points[0].x();
  for (std::size_t i = 1; i + 1 < points.size(); ++i) ASSERT_EQ(points[i].x() - points[i - 1].x(), step) << i;
}

}  // namespace
}  // namespace panoptic
