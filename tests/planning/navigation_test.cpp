// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/navigation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "panoptic/map/voxel_grid.h"
#include "panoptic/parallel.h"
#include "tests/expect_error.h"
#include "tests/planning/furnished.h"

namespace panoptic {
namespace {

using testing::HasSubstr;

Pose turned() {
  Pose pose = Pose::Identity();
  pose.linear() = (Eigen::AngleAxisd(-1.4, Vec3d::UnitX()) * Eigen::AngleAxisd(0.4, Vec3d::UnitZ())).matrix();
  pose.translation() = Vec3d(0.3, -0.2, 0.5);
  return pose;
}

struct Rooms {
  explicit Rooms(const Pose& pose, const AgentSize& agent = {})
      : map(test::furnished_map(pose)),
        frame(up_frame(map, Vec3d(pose.linear().col(2)))),
        floor(map, frame, agent),
        grid_from_room(frame.grid_from_world * pose) {}

  PanopticMap map;
  UpFrame frame;
  NavigationMesh floor;
  Pose grid_from_room;

  Path path(const Vec3d& from, const Vec3d& to) const { return floor.path(grid_from_room * from, grid_from_room * to); }
};

const Rooms& rooms() {
  static const Rooms kRooms{Pose::Identity()};
  return kRooms;
}
const Rooms& turned_rooms() {
  static const Rooms kRooms{turned()};
  return kRooms;
}

// Spots of the true and the found floor, without those within a cell of the true border.
double overlap(const Rooms& of, double radius_m) {
  constexpr double kCell_m = 0.048;
  double both = 0;
  double either = 0;
  for (double y = -1.49; y < 1.5; y += 0.02) {
    for (double x = -1.99; x < 2; x += 0.02) {
      const bool is_inner = test::may_stand({x, y}, radius_m + kCell_m);
      const bool is_true = test::may_stand({x, y}, radius_m);
      if (is_true != is_inner || test::may_stand({x, y}, radius_m - kCell_m) != is_true) continue;
      const bool is_found = of.floor.is_walkable(of.grid_from_room * Vec3d(x, y, 0));
      both += is_true && is_found ? 1 : 0;
      either += is_true || is_found ? 1 : 0;
    }
  }
  return both / either;
}

TEST(NavigationMesh, HoldsTheFloorThatIsFarEnoughFromEverything) {
  EXPECT_GT(overlap(rooms(), 0.2), 0.98);
  EXPECT_GT(overlap(turned_rooms(), 0.2), 0.98);
  EXPECT_EQ(rooms().floor.islands(), 1U);
  EXPECT_GT(rooms().floor.polygon_count(), 3U);
}

// A rail that lies across the floor.
struct Rail {
  double low_m;
  double high_m;
  LabelSlot label;
};

// A floor, and across all of it a rail whose voxels have this weight where the floor's have 1.
PanopticMap map_with_rail(const Rail& rail, float weight) {
  PanopticMap map({.voxel_size_m = 0.024F}, LabelSet("test", {{ClassId{1}, "floor", false, {0, 200, 0}}}));
  test::add_solids(map.voxels,
                   {test::solid_ground(Vec3d::UnitZ(), 0, test::pid(1)),
                    test::solid_box({-2, -0.03, rail.low_m}, {2, 0.03, rail.high_m}, rail.label)},
                   {-1.5, -1.5, -0.2}, {1.5, 1.5, 1});
  for (Slot slot = 0; slot < map.voxels.block_count(); ++slot) {
    test::BlockEdit edit(map.voxels.block(slot));
    for (int offset = 0; offset < kBlockVoxels; ++offset) {
      const VoxelIndex at = voxel_at(first_voxel(map.voxels.index_of(slot)), offset);
      const Vec3d place = center_m(at, map.voxels.voxel_size_m());
      float& of_voxel = (*edit).weight[static_cast<std::size_t>(offset)];
      if (place.z() > 0.025 && std::abs(place.y()) < 0.2) of_voxel = std::min(of_voxel, weight);
    }
  }
  return map;
}

TEST(NavigationMesh, SurfaceThatWasHardlySeenBesideTheRestIsNoObstacle) {
  const Rail in_the_air{0.45, 0.51, LabelSlot::kUnknown};
  const Rail crumbs_of_floor{-0.1, 0.07, test::pid(1)};
  for (const Rail& rail : {in_the_air, crumbs_of_floor}) {
    for (const auto& [weight, is_way] : {std::pair{1.0F, false}, {0.5F, false}, {0.1F, true}}) {
      const PanopticMap map = map_with_rail(rail, weight);
      const UpFrame frame = up_frame(map, Vec3d(Vec3d::UnitZ()));
      const NavigationMesh mesh(map, frame);
      const Path path = mesh.path(frame.grid_from_world * Vec3d(0, -1, 0), frame.grid_from_world * Vec3d(0, 1, 0));
      EXPECT_EQ(path.found, is_way) << rail.low_m << " m, " << weight;
    }
  }
}

TEST(NavigationMesh, AWideAgentDoesNotPassTheDoorway) {
  const Rooms wide(Pose::Identity(), {.radius_m = 0.48});
  EXPECT_GE(wide.floor.islands(), 2U);
  const Path path = wide.path({-0.8, 0, 0}, {0.75, 0.8, 0});
  EXPECT_FALSE(path.found);
  EXPECT_THAT(path.why_not, HasSubstr("no way"));
  EXPECT_TRUE(path.points_m.empty());
}

TEST(NavigationMesh, ALowAgentPassesUnderTheShelf) {
  EXPECT_FALSE(rooms().floor.is_walkable({-1.7, -1.1, 0}));
  EXPECT_TRUE(Rooms(Pose::Identity(), {.height_m = 1}).floor.is_walkable({-1.7, -1.1, 0}));
}

TEST(NavigationMesh, WaysTouchNothingAndAreFoundWhereThereAreAny) {
  constexpr double kRadius_m = 0.2;
  for (const Rooms* of : {&rooms(), &turned_rooms()}) {
    std::mt19937 random(5);
    const auto any_place = [&] {
      for (;;) {
        const auto share = [&] { return static_cast<double>(random() >> 8) / (1 << 24); };
        const double x = -2 + 4 * share();
        const double y = -1.5 + 3 * share();
        if (test::may_stand({x, y}, kRadius_m)) return Vec3d(x, y, 0);
      }
    };
    for (int i = 0; i < 40; ++i) {
      const Vec3d from = any_place();
      const Vec3d to = any_place();
      const Path path = of->path(from, to);
      ASSERT_TRUE(path.found) << from.transpose() << " to " << to.transpose() << ": " << path.why_not;
      EXPECT_GE(path.length_m, (to - from).norm() - 0.15);
      for (std::size_t p = 1; p < path.points_m.size(); ++p) {
        for (double share = 0; share <= 1; share += 0.1) {
          const Vec3d at =
              of->grid_from_room.inverse() * (path.points_m[p - 1] + share * (path.points_m[p] - path.points_m[p - 1]));
          EXPECT_TRUE(test::may_stand(at.head<2>(), kRadius_m - 0.024)) << at.transpose();
          EXPECT_NEAR(at.z(), 0, 0.06);
        }
      }
    }
  }
}

TEST(NavigationMesh, AWayLeadsToAThing) {
  const PanopticId chair = node_named(rooms().map, "chair_4");
  const Path path = rooms().floor.path_to({-1, 0, 0}, chair);
  ASSERT_TRUE(path.found) << path.why_not;
  const Vec3d end = path.points_m.back();
  EXPECT_TRUE(test::may_stand(end.head<2>(), 0.18));
  EXPECT_LT((end.head<2>() - Eigen::Vector2d(1.3, -0.7)).norm(), 0.6);
}

TEST(NavigationMesh, AThingBehindAWallIsNotReachedThroughTheWall) {
  const Rooms wide(Pose::Identity(), {.radius_m = 0.48});
  EXPECT_FALSE(wide.floor.path_to({-0.8, -0.2, 0}, node_named(wide.map, "chair_4")).found);
}

TEST(NavigationMesh, PlacesWhereNobodyStandsAreRefused) {
  const auto refused = [](const Vec3d& from) { return test::error_of([&] { rooms().path(from, {1, 0.8, 0}); }); };
  EXPECT_THAT(refused({1.3, -0.7, 0}), HasSubstr("the start 1.30,-0.70,0.00 lies in an obstacle"));
  EXPECT_THAT(refused({40, 0, 0}), HasSubstr("outside"));
  EXPECT_THAT(refused({std::numeric_limits<double>::quiet_NaN(), 0, 0}), HasSubstr("no place"));
  EXPECT_THAT(refused({-1, 0, 30}), HasSubstr("no floor"));
}

TEST(NavigationMesh, NamesThatTheMapLacksAreRefused) {
  EXPECT_EQ(node_named(rooms().map, "floor"), PanopticId{2});
  for (const char* name : {"sofa_4", "chair_5", "chair", "", "_", "chair_", "chair_99999999999"}) {
    EXPECT_THAT(test::error_of([&] { node_named(rooms().map, name); }), HasSubstr("there is no")) << name;
  }
}

TEST(NavigationMesh, AbsurdAgentsAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const AgentSize& agent) { return test::error_of([&] { check(agent); }); };
  EXPECT_THAT(refused({.radius_m = nan}), HasSubstr("a radius"));
  EXPECT_THAT(refused({.radius_m = -1}), HasSubstr("a radius"));
  EXPECT_THAT(refused({.height_m = 1e9}), HasSubstr("a height"));
  EXPECT_THAT(refused({.climb_m = 2}), HasSubstr("a climb"));
  EXPECT_THAT(refused({.height_m = 0.1, .climb_m = 0.2}), HasSubstr("no less"));
}

TEST(NavigationMesh, IsTheSameOnAnyNumberOfThreads) {
  const std::string on_all = turned_rooms().floor.detour_bytes();
  set_thread_count(1);
  EXPECT_EQ(NavigationMesh(turned_rooms().map, turned_rooms().frame).detour_bytes(), on_all);
  set_thread_count(0);
}

TEST(NavigationMesh, ItsTrianglesCoverItsArea) {
  const auto triangles = rooms().floor.triangles();
  double area = 0;
  for (const auto& t : triangles.corners) {
    const Vec3f a = triangles.vertices_m[t[1]] - triangles.vertices_m[t[0]];
    const Vec3f b = triangles.vertices_m[t[2]] - triangles.vertices_m[t[0]];
    EXPECT_GT(a.cross(b).z(), 0);
    area += double{a.cross(b).norm()} / 2;
  }
  EXPECT_NEAR(area, rooms().floor.area_m2(), 0.03 * area);
}

}  // namespace
}  // namespace panoptic
