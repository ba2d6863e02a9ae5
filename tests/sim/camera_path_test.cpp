// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/camera_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "panoptic/sim/catalogue.h"
#include "panoptic/sim/clearance_map.h"
#include "panoptic/sim/walk.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using ::testing::HasSubstr;

struct Case {
  Home home;
  std::vector<Pose> path;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> kCases = [] {
    const Catalogue catalogue;
    std::vector<Case> all;
    for (const int rooms : {1, 3, 4, 6, 8}) {
      const auto seed = static_cast<std::uint64_t>(rooms);
      Home home = make_home({seed, rooms}, catalogue);
      std::vector<Pose> path = make_camera_path(home, {seed, 0});
      all.push_back({std::move(home), std::move(path)});
    }
    return all;
  }();
  return kCases;
}

double angle_deg(const Pose& a, const Pose& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() * 180 / std::numbers::pi;
}

// The exact distance to every wall and box, without a grid.
double nearest_obstacle_m(const Home& home, const std::vector<FloorRect>& walls, const std::vector<ThingBox>& things,
                          const Vec3d& eye) {
  double nearest_m = 10;
  for (const FloorRect& wall : walls) nearest_m = std::min(nearest_m, distance_m(wall, eye.head<2>()));
  for (const ThingBox& thing : things) {
    if (thing.bottom_m < eye.z() && thing.top_m > eye.z() - 0.3)
      nearest_m = std::min(nearest_m, distance_m(thing.base, eye.head<2>()));
  }
  EXPECT_FALSE(home.rooms.empty());
  return nearest_m;
}

TEST(CameraPath, RefusesNumbersOfFramesOutOfRange) {
  const Home& home = cases()[0].home;
  EXPECT_THAT(test::error_of([&] { make_camera_path(home, {1, -1}); }), HasSubstr("frames = -1: a camera path has 1 to"));
  EXPECT_THAT(test::error_of([&] { make_camera_path(home, {1, 2'000'000'000}); }), HasSubstr("1000000 frames"));
  EXPECT_THAT(test::error_of([&] { make_camera_path(Home{}, {1, 0}); }), HasSubstr("at least one room"));
}

TEST(CameraPath, KeepsAwayFromWallsAndFurniture) {
  for (const auto& [home, path] : cases()) {
    const std::vector<FloorRect> walls = wall_rects(home);
    const std::vector<ThingBox> things = thing_boxes(home.scene);
    for (const Pose& pose : path)
      ASSERT_GE(nearest_obstacle_m(home, walls, things, pose.translation()), 0.25) << home.rooms.size();
  }
}

TEST(CameraPath, MovesAsAHandDoes) {
  for (const auto& [home, path] : cases()) {
    std::size_t fast = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      ASSERT_TRUE(is_rigid(path[i], 1e-9));
      ASSERT_GE(path[i].translation().z(), 1.2);
      ASSERT_LE(path[i].translation().z(), 1.7);
      ASSERT_GT(path[i].linear()(2, 1), -1);
      ASSERT_LT(path[i].linear()(2, 1), -0.7) << "the image's down points down";
      if (i == 0) continue;
      ASSERT_LT((path[i].translation() - path[i - 1].translation()).norm(), 0.04);
      const double turn_deg = angle_deg(path[i - 1], path[i]);
      ASSERT_LT(turn_deg, 4);
      fast += turn_deg > 2 ? 1 : 0;  // 60 degrees a second
    }
    EXPECT_LT(fast, path.size() / 8);
  }
}

TEST(CameraPath, LooksDownMostOfTheTime) {
  for (const auto& [home, path] : cases()) {
    const auto down = std::count_if(path.begin(), path.end(), [](const Pose& pose) {
      const double pitch_deg = std::asin(-pose.linear()(2, 2)) * 180 / std::numbers::pi;
      return pitch_deg > 8 && pitch_deg < 36;
    });
    EXPECT_GT(static_cast<double>(down), 0.9 * static_cast<double>(path.size()));
  }
}

TEST(CameraPath, VisitsEveryRoomAndComesBack) {
  for (const auto& [home, path] : cases()) {
    for (const Room& room : home.rooms) {
      const auto inside = std::count_if(path.begin(), path.end(), [&](const Pose& pose) {
        return room.floor.contains(Eigen::Vector2d(pose.translation().head<2>()));
      });
      EXPECT_GT(inside, 60) << "frames in a room of " << room.floor.volume() << " m2";
    }
    EXPECT_LT((path.front().translation() - path.back().translation()).head<2>().norm(), 0.2);
  }
}

// Whether a person could see it well from anywhere in its room.
bool can_be_seen(const Home& home, const ClearanceMap& clearance, const Sight& sight) {
  for (int cell = 0; cell < clearance.width() * clearance.height(); cell += 3) {
    const Eigen::Vector2d at = clearance.middle(cell);
    if (clearance[cell] < 0.32 || !home.rooms[sight.room].floor.contains(at)) continue;
    if (is_in_reach(sight, {at.x(), at.y(), 1.45})) return true;
  }
  return false;
}

// A sight's eye must look from 0.75 to 3 m with the spot within the 640x480 picture.
TEST(CameraPath, SeesMostOfWhatCanBeSeenFromAGoodDistance) {
  for (const auto& [home, path] : cases()) {
    const ClearanceMap clearance = walking_clearance(home, 1.75);
    double seen = 0;
    double sum = 0;
    for (const Sight& sight : sights(home, clearance)) {
      if (!can_be_seen(home, clearance, sight)) continue;
      sum += sight.weight;
      const bool is_seen = std::any_of(path.begin(), path.end(), [&](const Pose& pose) {
        const Vec3d in_camera = pose.inverse() * sight.point;
        return is_in_reach(sight, pose.translation()) && in_camera.z() > 0 && std::abs(in_camera.x() / in_camera.z()) < 0.55 &&
               std::abs(in_camera.y() / in_camera.z()) < 0.41;
      });
      seen += is_seen ? sight.weight : 0;
    }
    EXPECT_GT(seen / sum, 0.75) << home.rooms.size() << " rooms";
  }
}

TEST(CameraPath, TakesTheSameWayInAnyNumberOfFrames) {
  const auto& [home, path] = cases()[1];
  const std::vector<Pose> few = make_camera_path(home, {3, 101});
  ASSERT_EQ(few.size(), 101U);
  for (std::size_t i = 0; i < few.size(); ++i) {
    const double at = static_cast<double>(i) / 100 * static_cast<double>(path.size() - 1);
    const Pose& same = path[static_cast<std::size_t>(std::lround(at))];
    EXPECT_LT((few[i].translation() - same.translation()).norm(), 0.03);
    EXPECT_LT(angle_deg(few[i], same), 3);
  }
  EXPECT_EQ(make_camera_path(home, {3, 1}).size(), 1U);
}

TEST(CameraPath, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const auto& [home, path] = cases()[1];
  const std::vector<Pose> again = make_camera_path(home, {3, 0});
  ASSERT_EQ(again.size(), path.size());
  for (std::size_t i = 0; i < path.size(); ++i) ASSERT_EQ(again[i].matrix(), path[i].matrix());
  const std::vector<Pose> other = make_camera_path(home, {4, 50});
  const std::vector<Pose> mine = make_camera_path(home, {3, 50});
  EXPECT_NE(other[25].matrix(), mine[25].matrix());
}

}  // namespace
}  // namespace panoptic
