// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/footprints.h"

#include <gtest/gtest.h>

#include <cmath>

namespace panoptic::test {
namespace {

constexpr double kVoxel_m = 0.024;
constexpr PanopticId kThing{7};

// An upright face from one place to another, 1 m high, or a level one of 1 m by 1 m, sampled like a map's surface.
void add_face(LabelledSurface& surface, const Vec2d& from, const Vec2d& to) {
  const Vec2d along = to - from;
  const Vec2d normal = quarter_turn(along.normalized());
  for (double share = 0; share <= 1; share += kVoxel_m / along.norm()) {
    for (double z = 0; z <= 1; z += kVoxel_m) {
      const Vec2d at = from + share * along;
      surface.of_object[kThing].push_back({{at.x(), at.y(), z}, {normal.x(), normal.y(), 0}, kVoxel_m * kVoxel_m});
    }
  }
}

LabelledSurface empty_surface() {
  LabelledSurface surface;
  surface.voxel_m = kVoxel_m;
  surface.class_of[kThing] = ClassId{3};
  return surface;
}

Polygon only_footprint(const LabelledSurface& surface, const SeenEmpty& seen_empty) {
  const auto prints = footprints(surface, seen_empty);
  EXPECT_EQ(prints.size(), 1U);
  return prints.empty() ? Polygon() : prints.front().polygon;
}

TEST(Footprints, ACabinetOfWhichTwoFacesWereSeenIsABox) {
  LabelledSurface surface = empty_surface();
  add_face(surface, {0, 0}, {2, 0});
  add_face(surface, {2, 0}, {2, 1});
  const Polygon print = only_footprint(surface, [](const Vec3d& p) { return p.x() < 0 || p.y() < 0 || p.x() > 2; });
  EXPECT_GT(intersection_over_union(print, {{0, 0}, {2, 0}, {2, 1}, {0, 1}}), 0.95);
}

TEST(Footprints, ACounterAroundACornerIsNoBox) {
  LabelledSurface surface = empty_surface();
  const Polygon counter = {{0, 0}, {3, 0}, {3, 0.6}, {0.6, 0.6}, {0.6, 3}, {0, 3}};
  add_face(surface, {3, 0}, {3, 0.6});
  add_face(surface, {3, 0.6}, {0.6, 0.6});
  add_face(surface, {0.6, 0.6}, {0.6, 3});
  add_face(surface, {0.6, 3}, {0, 3});
  add_face(surface, {0, 3}, {0, 0});
  const Polygon print = only_footprint(surface, [&](const Vec3d& p) { return !contains(counter, p.head<2>()); });
  EXPECT_GT(intersection_over_union(print, counter), 0.85);
}

TEST(Footprints, SurfaceAcrossTheRoomWithTheSameLabelDoesNotCount) {
  LabelledSurface surface = empty_surface();
  add_face(surface, {0, 0}, {1, 0});
  add_face(surface, {1, 0}, {1, 1});
  add_face(surface, {4, 3}, {4.5, 3});
  const Polygon print = only_footprint(surface, [](const Vec3d& p) { return p.x() < 0 || p.y() < 0 || p.x() > 1 || p.y() > 1; });
  EXPECT_GT(intersection_over_union(print, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}), 0.9);
}

TEST(Footprints, PartsThatSomethingHidesFromEachOtherStayTogether) {
  LabelledSurface surface = empty_surface();
  add_face(surface, {0, 0}, {0.8, 0});
  add_face(surface, {1.4, 0}, {2, 0});
  add_face(surface, {2, 0}, {2, 0.5});
  const Polygon print = only_footprint(surface, [](const Vec3d& p) { return p.y() < -0.05; });
  EXPECT_GT(intersection_over_union(print, {{0, 0}, {2, 0}, {2, 0.5}, {0, 0.5}}), 0.95);
}

}  // namespace
}  // namespace panoptic::test
