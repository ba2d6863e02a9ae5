// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/carving.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <set>

#include "panoptic/map/space_cells.h"
#include "panoptic/map/voxel_grid.h"
#include "tests/fusion/space_scenes.h"

namespace panoptic {
namespace {

using test::on_arc;
using test::room;
using test::SeeingMap;

constexpr float kVoxel_m = 0.04F;

Frame seen(const test::Surface& scene, const Pose& pose) { return test::render(scene, test::space_camera(), pose); }

// The voxels that hold a surface, by their middles.
std::vector<Vec3d> surface_of(const VoxelMap& map) {
  std::vector<Vec3d> points;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    visit_surface(map.block(slot), map.index_of(slot), map.voxel_size_m(),
                  [&](LabelSlot, const VoxelIndex& voxel) { points.push_back(center_m(voxel, map.voxel_size_m())); });
  }
  return points;
}

std::size_t surface_near(const VoxelMap& map, const std::function<bool(const Vec3d&)>& where) {
  const std::vector<Vec3d> points = surface_of(map);
  return static_cast<std::size_t>(std::count_if(points.begin(), points.end(), where));
}

// All pixels within two voxels of the point see farther behind than that and the camera's error.
bool looks_past(const Frame& frame, const Vec3d& point) {
  const Vec3d p = frame.world_from_camera.inverse() * point;
  const Camera& c = frame.depth_camera;
  const double clear_m = 2 * kVoxel_m;
  if (p.z() < 2 * clear_m) return false;
  const int around_px = static_cast<int>(std::ceil(clear_m / (p.z() - clear_m) * c.fx));
  const int u = static_cast<int>(std::lround(p.x() / p.z() * c.fx + c.cx));
  const int v = static_cast<int>(std::lround(p.y() / p.z() * c.fy + c.cy));
  if (u < around_px || v < around_px || u + around_px >= c.width || v + around_px >= c.height) return false;
  for (int y = v - around_px; y <= v + around_px; ++y) {
    for (int x = u - around_px; x <= u + around_px; ++x) {
      if (frame.depth(x, y) < p.z() + clear_m + depth_error_m(static_cast<float>(p.z()))) return false;
    }
  }
  return true;
}

constexpr int kFirstVisit = 12;
constexpr int kSecondVisit = 16;
constexpr double kOldWall_m = 1.4;

// How much of the surface of a wall that moved back by a metre is left where it was looked through.
double left_of_a_moved_wall(const CarvingOptions& carving, const std::string& method) {
  SeeingMap seeing(kVoxel_m, carving, method);
  const test::Surface before = room({test::plane(Vec3d::UnitZ(), kOldWall_m)});
  for (int i = 0; i < kFirstVisit; ++i) seeing.add(seen(before, on_arc(i, 0.8, {0.6 * (i % 3 - 1), 0, 2})));
  std::vector<Frame> second;
  for (int i = 0; i < kSecondVisit; ++i) second.push_back(seen(room(), on_arc(i, 0.7, {0.6 * (i % 3 - 1), 0, 2})));
  const double clear_m = 2 * kVoxel_m;
  const auto was_looked_through = [&](const Vec3d& p) {
    const bool apart = std::abs(p.x()) < 2 - clear_m && std::abs(p.y()) < 1.2 - clear_m;  // from what is still there
    if (!apart || std::abs(p.z() - kOldWall_m) >= clear_m) return false;
    return std::count_if(second.begin(), second.end(), [&](const Frame& frame) { return looks_past(frame, p); }) >= 8;
  };
  const std::size_t old = surface_near(seeing.map.voxels, was_looked_through);
  EXPECT_GT(old, 3000U);
  for (const Frame& frame : second) seeing.add(frame);
  return static_cast<double>(surface_near(seeing.map.voxels, was_looked_through)) / static_cast<double>(old);
}

TEST(Carving, LeavesNextToNothingOfAWallThatMovedBetweenTwoVisits) {
  EXPECT_LT(left_of_a_moved_wall({}, "projective"), 0.02);
  EXPECT_LT(left_of_a_moved_wall({}, "raycast"), 0.02);
  EXPECT_GT(left_of_a_moved_wall({.enabled = false}, "projective"), 0.9) << "without carving it stays";
}

TEST(Carving, ClearsNothingOfAStaticRoom) {
  SeeingMap seeing(kVoxel_m);
  const test::Surface scene = room({test::sphere({0.3, 0.6, 0.8}, 0.4)});
  for (int i = 0; i < 24; ++i) {
    for (const CarvedVoxels& carved : seeing.add(seen(scene, on_arc(i, 0.8, {0.5 * (i % 4 - 1.5), 0.3, 2})))) {
      ADD_FAILURE() << std::popcount(carved.voxels) << " voxels";
    }
  }
}

// Vertical, of 2 cm radius: half a voxel.
test::Surface pole() {
  return [](const Vec3d& origin, const Vec3d& ray) -> std::optional<double> {
    const Vec3d o(origin.x() - 0.2, 0, origin.z() - 0.6);
    const Vec3d d(ray.x(), 0, ray.z());
    const double b = d.dot(o);
    const double root = b * b - d.squaredNorm() * (o.squaredNorm() - 0.02 * 0.02);
    if (root < 0) return std::nullopt;
    const double t = (-b - std::sqrt(root)) / d.squaredNorm();
    return t > 0 ? std::optional(t) : std::nullopt;
  };
}

TEST(Carving, ThinThingsStay) {
  SeeingMap seeing(kVoxel_m);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(seeing.add(seen(room({pole()}), on_arc(i, 0.6, {0.2, 0, 2}))).empty()) << i;
}

TEST(Carving, DarkThingsThatGiveNoReadingStay) {
  SeeingMap seeing(kVoxel_m);
  const test::Surface ball = test::sphere({0.1, 0, 0.8}, 0.3);
  for (int i = 0; i < 6; ++i) seeing.add(seen(room({ball}), on_arc(i, 0.5, {0.1, 0, 2})));
  const auto on_ball = [](const Vec3d& p) { return (p - Vec3d(0.1, 0, 0.8)).norm() < 0.36; };
  const std::size_t before = surface_near(seeing.map.voxels, on_ball);
  ASSERT_GT(before, 200U);
  for (int i = 6; i < 24; ++i) {
    const Pose pose = on_arc(i, 0.5, {0.1, 0, 2});
    Frame frame = seen(room(), pose);
    Image<float> depth(frame.depth.width(), frame.depth.height());
    for (int v = 0; v < depth.height(); ++v) {
      for (int u = 0; u < depth.width(); ++u) {
        const bool dark = ball(pose.translation(), pose.linear() * back_project(frame.depth_camera, u, v, 1)).has_value();
        depth(u, v) = dark ? 0.0F : frame.depth(u, v);
      }
    }
    frame.depth = std::move(depth);
    seeing.add(frame);
  }
  EXPECT_GT(surface_near(seeing.map.voxels, on_ball), before * 98 / 100);
}

// A thing vanishes from in front of a wall, from just above the floor: brute force over the readings of the same frame.
TEST(Carving, ClearsNothingWithinTwoVoxelsOfAReading) {
  SeeingMap seeing(kVoxel_m);
  const test::Surface ball = test::sphere({0.1, 0.9, 0.9}, 0.3);  // it touches the floor
  for (int i = 0; i < 8; ++i) seeing.add(seen(room({ball}), on_arc(i, 0.5, {0.1, 0.6, 2})));
  std::size_t carved = 0;
  for (int i = 8; i < 20; ++i) {
    const Frame frame = seen(room(), on_arc(i, 0.5, {0.1, 0.6, 2}));
    std::set<std::array<std::int32_t, 3>> near;  // voxels with a reading in them
    for (int v = 0; v < frame.depth.height(); ++v) {
      for (int u = 0; u < frame.depth.width(); ++u) {
        const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v)) / double{kVoxel_m};
        near.insert({static_cast<std::int32_t>(std::floor(p.x())), static_cast<std::int32_t>(std::floor(p.y())),
                     static_cast<std::int32_t>(std::floor(p.z()))});
      }
    }
    for (const CarvedVoxels& cleared : seeing.add(frame)) {
      for (std::uint64_t rest = cleared.voxels; rest != 0; rest &= rest - 1) {
        ++carved;
        const VoxelIndex at = voxel_at(first_voxel(seeing.map.voxels.index_of(cleared.slot)),
                                       offset_in_block(cleared.brick, std::countr_zero(rest)));
        // All that could lie within two voxels of its middle, whatever the place in the voxel.
        for (int n = 0; n < 27; ++n) ASSERT_FALSE(near.contains({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1}));
      }
    }
  }
  EXPECT_GT(carved, 500U);
}

TEST(Carving, TakesViewsFromSoManyPlaces) {
  const auto carved_by = [](int views, bool moving) {
    SeeingMap seeing(kVoxel_m, {.views = views});
    const test::Surface before = room({test::plane(Vec3d::UnitZ(), kOldWall_m)});
    seeing.add(seen(before, test::look_at({0, 0, -1}, {0, 0, 2})));
    int first = 0;
    for (int i = 1; i < 40 && first == 0; ++i) {
      const double x = moving ? 0.2 * i : 0;
      if (!seeing.add(seen(room(), test::look_at({x - (moving ? 0.6 : 0), 0, -1}, {0, 0, 2}))).empty()) first = i;
    }
    return first;
  };
  EXPECT_EQ(carved_by(1, true), 1);
  EXPECT_EQ(carved_by(3, true), 3);
  EXPECT_EQ(carved_by(5, true), 5);
  EXPECT_EQ(carved_by(2, false), 0) << "a camera that stands still is one place";
}

TEST(Carving, ASurfaceThatIsSeenAgainIsDoubtedNoMore) {
  SeeingMap seeing(kVoxel_m, {.views = 3});
  const test::Surface before = room({test::plane(Vec3d::UnitZ(), kOldWall_m)});
  const auto pose = [](int i) { return test::look_at({0.2 * i - 0.4, 0, -1}, {0, 0, 2}); };
  seeing.add(seen(before, pose(0)));
  for (const int i : {1, 2}) EXPECT_TRUE(seeing.add(seen(room(), pose(i))).empty());
  EXPECT_GT(seeing.map.free_space.doubt_count(), 100U);
  seeing.add(seen(before, pose(3)));
  for (const int i : {4, 5}) EXPECT_TRUE(seeing.add(seen(room(), pose(i))).empty());
}

}  // namespace
}  // namespace panoptic
