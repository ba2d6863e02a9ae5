// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/depth_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "panoptic/fusion/frame_view.h"
#include "panoptic/fusion/grazing.h"
#include "panoptic/map/brick_pool.h"
#include "tests/block_planes.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

// A room with a ball in it, seen from somewhere inside; every tenth pixel has no depth.
struct View {
  View(std::mt19937& random, float voxel_size_m) : voxel_m(voxel_size_m), band{4 * voxel_m, voxel_m} {
    std::uniform_real_distribution<double> place(-1, 1);
    const auto somewhere = [&] {
      Vec3d point;
      for (int axis = 0; axis < 3; ++axis) point[axis] = place(random);
      return point;
    };
    const int width = 20 + static_cast<int>(random() % 200);
    const Camera camera = test::small_camera(width, width * 3 / 4 + static_cast<int>(random() % 3));
    std::vector<test::Surface> surfaces{test::sphere({0.3, 0.2, 0}, 0.5)};
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1.5, 1.7}) surfaces.push_back(test::plane(Vec3d::Unit(axis), side));
    }
    const Vec3d eye = somewhere();
    const Frame frame = test::render(test::nearest_of(surfaces), camera, test::look_at(eye, somewhere()));
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) depth.push_back(random() % 10 == 0 ? 0.0F : frame.depth(u, v));
    }
    depth.push_back(0);
    color.assign(depth.size(), 0xFF102030);
    label.assign(depth.size(), LabelSlot{5});
    const auto f = static_cast<float>(camera.fx);
    frame_view = {{depth.data(),
                   color.data(),
                   label.data(),
                   camera.width,
                   camera.height,
                   f,
                   f,
                   static_cast<float>(camera.cx),
                   static_cast<float>(camera.cy),
                   {}},
                  camera,
                  frame.world_from_camera.linear().cast<float>(),
                  frame.world_from_camera.translation(),
                  8};
    grazing_scales(frame_view.pixels, band, voxel_m, scale);
    frame_view.pixels.scale = scale.data();
    tiles.build(frame_view.pixels, band);
  }

  float voxel_m;
  Band band;
  std::vector<float> depth;
  std::vector<std::uint32_t> color;
  std::vector<LabelSlot> label;
  std::vector<float> scale;
  FrameView frame_view;
  DepthTiles tiles;
};

// The block that a pixel's surface lies in, or one beside it.
BlockIndex block_near_surface(const View& view, std::mt19937& random) {
  const FrameView& frame = view.frame_view;
  const auto u = static_cast<int>(random() % static_cast<unsigned>(frame.pixels.width));
  const auto v = static_cast<int>(random() % static_cast<unsigned>(frame.pixels.height));
  const Vec3d point = frame.camera_in_world_m + (frame.ray(u, v) * view.depth[frame.index(u, v)]).cast<double>();
  const double block_m = double{view.voxel_m} * kBlockSide;
  const auto along = [&](int axis) {
    return static_cast<std::int32_t>(std::floor(point[axis] / block_m)) + static_cast<std::int32_t>(random() % 3) - 1;
  };
  return {along(0), along(1), along(2)};
}

bool is_same(const VoxelBlock& a, const VoxelBlock& b) {
  for (int n = 0; n < kBlockBricks; ++n) {
    if (a.brick(n).stored() != b.brick(n).stored()) return false;
  }
  return test::planes_of(a).distance == test::planes_of(b).distance && test::planes_of(a).label == test::planes_of(b).label;
}

TEST(DepthTiles, LeaveOutNoBrickInWhichAVoxelIsObserved) {
  std::mt19937 random(5);
  for (const float voxel_m : {0.01F, 0.03F, 0.08F, 0.3F}) {
    std::size_t looked_at = 0;
    std::size_t observed = 0;
    std::size_t all = 0;
    for (int i = 0; i < 6; ++i) {
      const View view(random, voxel_m);
      for (int n = 0; n < 150; ++n) {
        const BlockInCamera place = view.frame_view.in_camera(block_near_surface(view, random), voxel_m);
        const BricksInBand bricks = bricks_in_band(view.frame_view.pixels, view.tiles, place, view.band);
        BrickPool pool;
        VoxelBlock some(pool);
        VoxelBlock whole(pool);
        integrate_block(view.frame_view.pixels, place, view.band, bricks, some);
        integrate_block(view.frame_view.pixels, place, view.band, {~std::uint64_t{0}, true}, whole);
        ASSERT_TRUE(is_same(some, whole)) << voxel_m << " view " << i << " block " << n;
        looked_at += static_cast<std::size_t>(std::popcount(bricks.bricks));
        for (int b = 0; b < kBlockBricks; ++b) observed += whole.brick(b).count() > 0 ? 1 : 0;
        all += kBlockBricks;
      }
    }
    EXPECT_GT(observed, 200U) << voxel_m;
    EXPECT_LT(looked_at, observed + (all - observed) / 2) << voxel_m << ": half of what nobody observes need not be looked at";
  }
}

TEST(DepthTiles, HoldTheRangeOfTheirPixelsOnEveryLevel) {
  std::mt19937 random(6);
  for (const auto& [width, height] : {std::pair{64, 64}, {1, 1}, {7, 90}, {161, 119}, {8, 9}}) {
    std::vector<float> depth;
    for (int i = 0; i < width * height; ++i)
      depth.push_back(random() % 3 == 0 ? 0.0F : static_cast<float>(random() % 5000) / 1e3F);
    DepthTiles tiles;
    KernelFrame frame;
    frame.depth = depth.data();
    frame.width = width;
    frame.height = height;
    tiles.build(frame, {});
    int side = 8;
    for (const DepthTiles::Level& level : tiles.levels()) {
      ASSERT_EQ(level.columns, (width + side - 1) / side);
      ASSERT_EQ(level.rows, (height + side - 1) / side);
      std::vector<float> nearest(level.tiles.size(), std::numeric_limits<float>::infinity());
      std::vector<float> farthest(level.tiles.size(), -std::numeric_limits<float>::infinity());
      for (int i = 0; i < width * height; ++i) {
        const float z = depth[static_cast<std::size_t>(i)];
        const auto tile = static_cast<std::size_t>(i / width / side * level.columns + i % width / side);
        if (z <= 0) continue;
        nearest[tile] = std::min(nearest[tile], z);
        farthest[tile] = std::max(farthest[tile], z);
      }
      for (std::size_t t = 0; t < level.tiles.size(); ++t) {
        EXPECT_EQ(level.tiles[t].nearest_m, nearest[t]);
        EXPECT_EQ(level.tiles[t].farthest_m, farthest[t]);
      }
      side *= 2;
    }
    EXPECT_EQ(tiles.levels().back().tiles.size(), 1U);
  }
}

}  // namespace
}  // namespace panoptic
