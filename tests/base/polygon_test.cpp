// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace panoptic {
namespace {

const Polygon kSquare = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
const Polygon kCornered = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};  // an L of 5

TEST(Polygon, AreaAndMiddleAreThoseOfItsTriangles) {
  EXPECT_DOUBLE_EQ(signed_area(kSquare), 4);
  EXPECT_DOUBLE_EQ(signed_area(kCornered), 5);
  EXPECT_DOUBLE_EQ(signed_area({kSquare.rbegin(), kSquare.rend()}), -4);
  // Three square metres with their middle at (1.5, 0.5), two with theirs at (0.5, 2).
  EXPECT_LT((centroid(kCornered) - Vec2d((3 * 1.5 + 2 * 0.5) / 5, (3 * 0.5 + 2 * 2.0) / 5)).norm(), 1e-12);
  EXPECT_EQ(signed_area({}), 0);
  EXPECT_LT((centroid({{1, 2}, {3, 4}}) - Vec2d(2, 3)).norm(), 1e-12);
}

TEST(Polygon, ContainsWhatLiesInside) {
  EXPECT_TRUE(contains(kCornered, {0.5, 2.5}));
  EXPECT_TRUE(contains(kCornered, {2.5, 0.5}));
  EXPECT_FALSE(contains(kCornered, {2, 2}));
  EXPECT_FALSE(contains(kCornered, {-0.1, 1}));
  EXPECT_FALSE(contains({}, {0, 0}));
}

TEST(Polygon, TheHullHoldsEveryPointAndTurnsLeftAlone) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vec2d> points;
  for (int i = 0; i < 500; ++i) points.emplace_back(normal(random), 3 * normal(random));
  const Polygon hull = convex_hull(points);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2d edge = hull[(i + 1) % hull.size()] - hull[i];
    for (const Vec2d& p : points) EXPECT_GE(cross(edge, p - hull[i]), -1e-9);
  }
  EXPECT_TRUE(convex_hull({}).empty());
}

TEST(Polygon, TheSmallestBoxIsFoundInAnyDirection) {
  for (double angle = 0.05; angle < 3; angle += 0.3) {
    const Vec2d axis(std::cos(angle), std::sin(angle));
    const FlatBox box = smallest_box(corners({{4, -1}, axis, {3, 1.5}}));
    EXPECT_LT((box.center - Vec2d(4, -1)).norm(), 1e-9);
    EXPECT_LT((box.size_m - Vec2d(3, 1.5)).norm(), 1e-9);
    EXPECT_NEAR(std::abs(box.axis.dot(axis)), 1, 1e-12);
  }
}

TEST(Polygon, SimplifyingKeepsCornersAndDropsSteps) {
  Polygon stairs;
  for (int i = 0; i < 40; ++i) {
    stairs.emplace_back(i * 0.05, i % 2 * 0.01);
  }
  stairs.insert(stairs.end(), {{2, 1}, {0, 1}});
  const Polygon simple = simplified(stairs, 0.03);
  EXPECT_LE(simple.size(), 5U);
  EXPECT_NEAR(signed_area(simple), 2, 0.05);
  EXPECT_EQ(simplified(kCornered, 0.1).size(), kCornered.size());
}

TEST(Polygon, IntersectionOverUnionIsThatOfAreas) {
  EXPECT_NEAR(intersection_over_union(kSquare, kSquare), 1, 1e-9);
  const Polygon shifted = {{1, 0}, {3, 0}, {3, 2}, {1, 2}};
  EXPECT_NEAR(intersection_over_union(kSquare, shifted), 2.0 / 6, 1e-9);
  EXPECT_NEAR(intersection_over_union(kSquare, kCornered), 3.0 / 6, 2e-3);
  EXPECT_EQ(intersection_over_union(kSquare, {{5, 5}, {6, 5}, {6, 6}}), 0);
  EXPECT_EQ(intersection_over_union({}, {}), 0);
}

}  // namespace
}  // namespace panoptic
