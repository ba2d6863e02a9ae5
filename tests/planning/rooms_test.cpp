// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Walls, doors and rooms of two rooms that stand in any direction.
#include "panoptic/planning/rooms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "panoptic/planning/doors.h"

namespace panoptic {
namespace {

constexpr double kStep_m = 0.025;
constexpr double kWall_m = 0.12;
constexpr double kCeiling_m = 2.5;
constexpr double kDoorTop_m = 2.05;
constexpr double kHidden_m = 0.7;  // of a wall, by a shelf in one room and an open leaf in the other

enum class Wall { kSolid, kWithDoorway, kHiddenBesideDoorway };

// Two rooms of 3 m by 4 m, side by side, with a doorway of 0.9 m in the wall between them; all turned.
struct TwoRooms {
  explicit TwoRooms(double yaw, Wall between = Wall::kWithDoorway) : turn(yaw), is_hidden(between == Wall::kHiddenBesideDoorway) {
    const bool has_doorway = between != Wall::kSolid;
    door_low_m = has_doorway ? 0.3 : 9;
    door_high_m = has_doorway ? 1.2 : 9;
    surface.voxel_m = 0.024;
    for (const double x : {0.0, 3 + kWall_m}) add_room(x);
    if (has_doorway) add_jambs();
    floor.grid = grid_over(Eigen::AlignedBox2d(Vec2d(-8, -8), Vec2d(8, 8)), 0.048, 2);
    floor.open.assign(floor.grid.size(), 0);
    for (const double x : {0.0, 3 + kWall_m})
      add_polygon(floor.grid, turned({{x, 0}, {x + 3, 0}, {x + 3, 4}, {x, 4}}), floor.open);
    const Polygon threshold = {{2.9, door_low_m}, {3.3, door_low_m}, {3.3, door_high_m}, {2.9, door_high_m}};
    if (has_doorway) add_polygon(floor.grid, turned(threshold), floor.open);
    floor.wall.assign(floor.grid.size(), 0);
    for (const LabelledPoint& p : surface.wall) {
      if (p.at.z() > kWallHigh_m) continue;
      const std::size_t cell = floor.grid.cell_at(p.at.head<2>()).value();
      floor.wall[cell] = 1;
      floor.open[cell] = 0;
    }
  }

  Polygon turned(Polygon polygon) const {
    for (Vec2d& p : polygon) p = turn * p;
    return polygon;
  }

  HomePlan plan() const {
    const std::vector<WallPlane> planes = find_wall_planes(surface);
    HomePlan result;
    result.walls = wall_lines(planes, floor);
    result.doors = find_doors(surface, labels, {planes, floor});
    add_rooms(floor, labels, result);
    return result;
  }

  Eigen::Rotation2Dd turn;
  bool is_hidden;
  double door_low_m;
  double door_high_m;
  LabelSet labels = load_label_set("scannet20");
  LabelledSurface surface;
  OpenFloor floor;

 private:
  void add_face(const Vec2d& from, const Vec2d& to, bool has_door) {
    const Vec2d along = (to - from).normalized();
    const Vec2d normal = turn * quarter_turn(along);
    for (double t = kStep_m / 2; t < (to - from).norm(); t += kStep_m) {
      const Vec2d at = from + along * t;
      const bool in_door = has_door && at.y() > door_low_m && at.y() < door_high_m;
      if (has_door && is_hidden && at.y() > door_low_m && at.y() < door_high_m + kHidden_m) continue;
      for (double z = in_door ? kDoorTop_m : kStep_m / 2; z < kCeiling_m; z += kStep_m) {
        const Vec2d p = turn * at;
        surface.wall.push_back({{p.x(), p.y(), z}, {normal.x(), normal.y(), 0}, kStep_m * kStep_m});
      }
    }
  }
  void add_room(double x) {
    const bool is_left = x == 0;
    add_face({x, 0}, {x + 3, 0}, false);
    add_face({x + 3, 0}, {x + 3, 4}, is_left);
    add_face({x + 3, 4}, {x, 4}, false);
    add_face({x, 4}, {x, 0}, !is_left);
  }
  void add_jambs() {
    add_face({3, door_low_m}, {3 + kWall_m, door_low_m}, false);
    add_face({3 + kWall_m, door_high_m}, {3, door_high_m}, false);
  }
};

TEST(Walls, AreFoundInAnyDirection) {
  for (const double yaw : {0.0, 0.35, 2.1}) {
    const TwoRooms home(yaw);
    const auto walls = wall_lines(find_wall_planes(home.surface), home.floor);
    double length_m = 0;
    for (const WallLine& wall : walls) length_m += (wall.to - wall.from).norm();
    EXPECT_NEAR(length_m, 28 - 2 * 0.9, 0.6) << yaw;
    for (const WallLine& wall : walls) {
      const Vec2d along = home.turn.inverse() * (wall.to - wall.from).normalized();
      EXPECT_GT(along.cwiseAbs().maxCoeff(), 0.999);
    }
  }
}

TEST(Doors, AGapThatOneCanWalkThroughIsOne) {
  for (const double yaw : {0.0, 0.35, 2.1}) {
    const TwoRooms home(yaw);
    const HomePlan plan = home.plan();
    ASSERT_EQ(plan.doors.size(), 1U) << yaw;
    const Opening& door = plan.doors[0];
    EXPECT_LT((door.center.head<2>() - home.turn * Vec2d(3 + kWall_m / 2, 0.75)).norm(), 0.06);
    EXPECT_NEAR(door.width_m, 0.9, 0.08);
    EXPECT_NEAR(door.height_m, kDoorTop_m, 0.05);
    EXPECT_NEAR(door.wall_m, kWall_m, 0.02);
    EXPECT_TRUE(door.is_open);
    EXPECT_THAT(door.rooms, testing::UnorderedElementsAre(0, 1));
  }
}

TEST(Doors, AJambIsEnoughWhereTheWallBesideItAndAboveIsHidden) {
  for (const double yaw : {0.0, 0.35, 2.1}) {
    const TwoRooms home(yaw, Wall::kHiddenBesideDoorway);
    const HomePlan plan = home.plan();
    ASSERT_EQ(plan.doors.size(), 1U) << yaw;
    EXPECT_LT((plan.doors[0].center.head<2>() - home.turn * Vec2d(3 + kWall_m / 2, 0.75)).norm(), 0.06);
    EXPECT_NEAR(plan.doors[0].width_m, 0.9, 0.08);
    EXPECT_EQ(plan.rooms.size(), 2U);
  }
}

TEST(Doors, AWallWithoutAGapHasNone) { EXPECT_TRUE(TwoRooms(0.35, Wall::kSolid).plan().doors.empty()); }

TEST(Doors, AClosedLeafInTheWallIsADoor) {
  constexpr auto kLeaf = static_cast<PanopticId>(100);
  TwoRooms home(0.35, Wall::kSolid);
  std::erase_if(home.surface.wall, [&](const LabelledPoint& p) {
    const Vec2d at = home.turn.inverse() * Vec2d(p.at.head<2>());
    return at.y() < 0.1 && at.x() > 1 && at.x() < 1.9 && p.at.z() < kDoorTop_m;
  });
  for (double x = 1; x < 1.9; x += kStep_m) {
    for (double z = 0; z < kDoorTop_m; z += kStep_m) {
      const Vec2d at = home.turn * Vec2d(x, -0.07);
      const Vec2d normal = home.turn * Vec2d(0, 1);
      home.surface.of_object[kLeaf].push_back({{at.x(), at.y(), z}, {normal.x(), normal.y(), 0}, kStep_m * kStep_m});
    }
  }
  home.surface.class_of[kLeaf] = home.labels.find(std::string_view("door"))->id;
  const HomePlan plan = home.plan();
  ASSERT_EQ(plan.doors.size(), 1U);
  EXPECT_FALSE(plan.doors[0].is_open);
  EXPECT_EQ(plan.doors[0].leaf, kLeaf);
  EXPECT_NEAR(plan.doors[0].width_m, 0.9, 0.06);
  EXPECT_EQ(plan.doors[0].rooms.size(), 1U);
}

TEST(Rooms, AreDividedAtTheDoorAndEndAtTheWalls) {
  for (const double yaw : {0.0, 0.35, 2.1}) {
    const TwoRooms home(yaw);
    const HomePlan plan = home.plan();
    ASSERT_EQ(plan.rooms.size(), 2U) << yaw;
    for (const double x : {0.0, 3 + kWall_m}) {
      const Polygon expected = home.turned({{x, 0}, {x + 3, 0}, {x + 3, 4}, {x, 4}});
      double best = 0;
      for (const MappedRoom& room : plan.rooms) best = std::max(best, intersection_over_union(room.polygon, expected));
      EXPECT_GT(best, 0.96) << yaw;
    }
    for (const MappedRoom& room : plan.rooms) {
      EXPECT_NEAR(room.area_m2, 12, 0.5);
      EXPECT_THAT(room.doors, testing::ElementsAre(0));
      EXPECT_EQ(room.polygon.size(), 4U) << yaw;
    }
  }
}

TEST(Rooms, FloorHiddenByAWardrobeBelongsToTheRoom) {
  TwoRooms home(0.35);
  const Polygon wardrobe = home.turned({{0, 3.4}, {1.5, 3.4}, {1.5, 4}, {0, 4}});
  CellSet hidden(home.floor.grid.size(), 0);
  add_polygon(home.floor.grid, wardrobe, hidden);
  for (std::size_t cell = 0; cell < hidden.size(); ++cell) {
    if (hidden[cell] != 0) home.floor.open[cell] = home.floor.wall[cell] = 0;
  }
  std::erase_if(home.surface.wall, [&](const LabelledPoint& p) {
    return contains(home.turned({{-0.1, 3.4}, {1.5, 3.4}, {1.5, 4.1}, {-0.1, 4.1}}), p.at.head<2>());
  });
  const HomePlan plan = home.plan();
  ASSERT_EQ(plan.rooms.size(), 2U);
  for (const MappedRoom& room : plan.rooms) EXPECT_NEAR(room.area_m2, 12, 0.6);
}

TEST(Rooms, ThingsTellTheClass) {
  EXPECT_EQ(room_class({"chair", "toilet", "sink"}), "bathroom");
  EXPECT_EQ(room_class({"bed", "desk", "chair"}), "bedroom");
  EXPECT_EQ(room_class({"sofa", "refrigerator", "table"}), "living room");
  EXPECT_EQ(room_class({"bed", "counter", "chair"}), "living room");
  EXPECT_EQ(room_class({"sink", "refrigerator", "table", "chair"}), "kitchen");
  EXPECT_EQ(room_class({"desk", "chair", "bookshelf"}), "office");
  EXPECT_EQ(room_class({"table", "chair"}), "dining room");
  EXPECT_EQ(room_class({"cabinet"}), "room");
}

TEST(Rooms, EdgesMoveOntoWallsAndMeetInCorners) {
  const std::vector<WallLine> walls = {
      {{0, 0}, {3, 0}, {0, 1}}, {{3, 0}, {3, 2}, {-1, 0}}, {{3, 2}, {0, 2}, {0, -1}}, {{0, 2}, {0, 0}, {1, 0}}};
  const Polygon rough = {{0.05, 0.1}, {2.9, 0.06}, {2.93, 1.8}, {2.8, 1.95}, {0.1, 1.9}};
  const Polygon exact = on_walls(rough, walls);
  EXPECT_EQ(exact.size(), 4U);
  EXPECT_NEAR(signed_area(exact), 6, 1e-6);
  EXPECT_EQ(on_walls(rough, {}).size(), rough.size());
}

}  // namespace
}  // namespace panoptic
