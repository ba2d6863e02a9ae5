// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/space_observer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "panoptic/parallel.h"
#include "tests/fusion/space_scenes.h"

namespace panoptic {
namespace {

using test::room;
using test::SeeingMap;

// A frame of a room with a ball; a patch and single pixels have no reading.
Frame spotted_frame(std::mt19937& random) {
  const auto between = [&](double low, double high) { return low + (high - low) * static_cast<double>(random() % 1000) / 1000; };
  const double z = between(-2, 0);  // one after the other: arguments have no order
  const double y = between(-0.8, 0.8);
  const Vec3d eye(between(-1.5, 1.5), y, z);
  Frame frame = test::render(room({test::sphere({0.3, 0.4, 1}, 0.4)}), test::space_camera(),
                             test::look_at(eye, {between(-1, 1), between(-1, 1), 2}));
  Image<float> depth(frame.depth.width(), frame.depth.height());
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      const bool missing = random() % 5000 == 0 || (u > 200 && u < 230 && v > 100 && v < 150);
      depth(u, v) = missing ? 0.0F : frame.depth(u, v);
    }
  }
  frame.depth = std::move(depth);
  return frame;
}

// A cell with `grown_m` added on every side, in the camera: a box along the camera's axes.
struct BoxInCamera {
  Vec3d low;
  Vec3d high;

  BoxInCamera(const CellIndex& cell, double cell_m, double grown_m, const Pose& world_from_camera) {
    const Vec3d middle = world_from_camera.inverse() * Vec3d((Vec3d(cell[0], cell[1], cell[2]) + Vec3d::Constant(0.5)) * cell_m);
    const Vec3d half = world_from_camera.linear().transpose().cwiseAbs() * Vec3d::Constant(cell_m / 2 + grown_m);
    low = middle - half;
    high = middle + half;
  }
};

// The definition, pixel by pixel: all pixels that the box covers, and `slack_px` around, lie in the image and see farther than
// the box and the camera's error. Those without reading may count as doing so.
bool is_seen_through(const Frame& frame, const BoxInCamera& box, int slack_px, bool missing) {
  if (box.low.z() <= 1e-3) return false;
  const Camera& c = frame.depth_camera;
  const auto first = [&](double low, double focal, double center) {
    return static_cast<int>(std::floor(low / (low < 0 ? box.low.z() : box.high.z()) * focal + center)) - slack_px;
  };
  const auto last = [&](double high, double focal, double center) {
    return static_cast<int>(std::ceil(high / (high < 0 ? box.high.z() : box.low.z()) * focal + center)) + slack_px;
  };
  const int u0 = first(box.low.x(), c.fx, c.cx);
  const int v0 = first(box.low.y(), c.fy, c.cy);
  const int u1 = last(box.high.x(), c.fx, c.cx);
  const int v1 = last(box.high.y(), c.fy, c.cy);
  if (u0 < 0 || v0 < 0 || u1 >= c.width || v1 >= c.height) return false;
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u) {
      if (missing && frame.depth(u, v) <= 0) continue;
      if (!(frame.depth(u, v) > box.high.z() + depth_error_m(static_cast<float>(box.high.z())))) return false;
    }
  }
  return true;
}

// A cell that the naive reference takes for empty with a tile's width to spare is; none is that has a reading too near.
TEST(SpaceObserver, SeesTheEmptyCellsOfTheNaiveReference) {
  constexpr float kVoxel_m = 0.04F;
  constexpr double kCell_m = 4 * 0.04;
  std::mt19937 random(5);
  for (int round = 0; round < 3; ++round) {
    SeeingMap seeing(kVoxel_m);
    const Frame frame = spotted_frame(random);
    seeing.add(frame);
    const FreeSpaceMap& space = seeing.map.free_space;
    int empty = 0;
    int certain = 0;
    for (int x = -16; x < 16; ++x) {
      for (int y = -10; y < 10; ++y) {
        for (int z = -18; z < 18; ++z) {
          const bool is_free = space.at({x, y, z}) == Space::kFree;
          const BoxInCamera box({x, y, z}, kCell_m, 2 * 0.04 * 0.999, frame.world_from_camera);
          const BoxInCamera wide({x, y, z}, kCell_m, 2 * 0.04 * 1.001, frame.world_from_camera);
          empty += is_free ? 1 : 0;
          if (is_free) {
            ASSERT_TRUE(is_seen_through(frame, box, 0, true)) << x << " " << y << " " << z;
          }
          const bool is_certain = is_seen_through(frame, wide, 12, false);
          certain += is_certain ? 1 : 0;
          if (is_certain) {
            ASSERT_TRUE(is_free) << x << " " << y << " " << z;
          }
        }
      }
    }
    EXPECT_GT(certain, 30);
    EXPECT_GE(empty, certain);
  }
}

TEST(SpaceObserver, SaysNothingWhereMostPixelsHaveNoReading) {
  const auto evidence_with_hole = [](int wide_px) {
    SeeingMap seeing(0.04F);
    Frame frame = test::render(room(), test::space_camera(), test::look_at({0, 0, -1}, {0, 0, 2}));
    Image<float> depth = Image<float>(frame.depth.width(), frame.depth.height());
    for (int v = 0; v < depth.height(); ++v) {
      for (int u = 0; u < depth.width(); ++u) depth(u, v) = std::abs(u - 160) * 2 < wide_px ? 0.0F : frame.depth(u, v);
    }
    frame.depth = std::move(depth);
    seeing.add(frame);
    return seeing.map.free_space.record(*seeing.map.free_space.cell_around({0.08, 0.08, 1})).evidence;
  };
  EXPECT_EQ(evidence_with_hole(0), 1);
  EXPECT_EQ(evidence_with_hole(6), 1);
  EXPECT_EQ(evidence_with_hole(60), 0);
}

TEST(SpaceObserver, WhatASampledPixelSeesIsOccupied) {
  std::mt19937 random(6);
  SeeingMap seeing(0.04F);
  const Frame frame = spotted_frame(random);
  seeing.add(frame);
  std::set<CellIndex> expected;
  for (int v = 4; v < frame.depth.height(); v += 8) {
    for (int u = 4; u < frame.depth.width(); u += 8) {
      const float z = frame.depth(u, v);
      // Those on the edge of two cells may fall to either side.
      for (const double nudge : {0.9999, 1.0001}) {
        if (z > 0)
          expected.insert(
              *seeing.map.free_space.cell_around(frame.world_from_camera * back_project(frame.depth_camera, u, v, z * nudge)));
      }
    }
  }
  std::size_t occupied = 0;
  seeing.map.free_space.for_each([&](const CellIndex& cell, Space space) {
    if (space != Space::kOccupied) return;
    ++occupied;
    EXPECT_TRUE(expected.contains(cell));
  });
  EXPECT_GT(occupied, expected.size() * 8 / 10);
}

TEST(SpaceObserver, GivesTheSameMapAtAnyThreadCount) {
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 3, 8}) {
    set_thread_count(threads);
    SeeingMap seeing(0.05F);
    for (int i = 0; i < 8; ++i) {
      seeing.add(
          test::render(room({test::plane({0, 0, 1}, i < 4 ? 1.0 : 2.0)}), test::space_camera(), test::on_arc(i, 0.5, {0, 0, 2})));
    }
    hashes.insert(seeing.map.free_space.hash() ^ seeing.map.voxels.hash());
  }
  set_thread_count(0);
  EXPECT_EQ(hashes.size(), 1U);
}

TEST(SpaceObserver, AFrameFromWhereTheLastOneWasTakenTellsNothingNew) {
  SeeingMap seeing(0.05F);
  const Frame frame = test::render(room(), test::space_camera(), test::look_at({0, 0, -1}, {0, 0, 2}));
  seeing.add(frame);
  const std::uint64_t first = seeing.map.free_space.hash();
  const CellIndex ahead = *seeing.map.free_space.cell_around({0, 0, 1});
  for (int i = 1; i < 10; ++i) seeing.add(frame);
  EXPECT_EQ(seeing.map.free_space.hash(), first);
  seeing.add(frame);
  EXPECT_EQ(seeing.map.free_space.record(ahead).evidence, 2) << "after ten frames";
  Frame moved = frame;
  moved.world_from_camera.translation().x() += 0.06;
  seeing.add(moved);
  EXPECT_EQ(seeing.map.free_space.record(ahead).evidence, 3);
}

TEST(SpaceObserver, RecordsNothingWhereItIsSwitchedOff) {
  MapOptions off = test::voxels_of(0.05F);
  off.free_space = false;
  SeeingMap seeing(0.05F);
  seeing.observer = SpaceObserver(off, {.enabled = false});
  seeing.add(test::render(room(), test::space_camera(), Pose::Identity()));
  EXPECT_TRUE(seeing.map.free_space.empty());
}

}  // namespace
}  // namespace panoptic
