// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/table_tops.h"

#include <gtest/gtest.h>

#include <cmath>

namespace panoptic {
namespace {

constexpr double kStep_m = 0.02;
constexpr auto kTable = static_cast<PanopticId>(100);
bool nothing_is_empty(const Vec3d&) { return false; }
constexpr auto kVase = static_cast<PanopticId>(101);

// Level points over a rectangle that was turned.
std::vector<LabelledPoint> level(const FlatBox& box, double height_m) {
  std::vector<LabelledPoint> points;
  for (double u = -box.size_m.x() / 2; u <= box.size_m.x() / 2 + 1e-9; u += kStep_m) {
    for (double v = -box.size_m.y() / 2; v <= box.size_m.y() / 2 + 1e-9; v += kStep_m) {
      const Vec2d at = box.center + box.axis * u + quarter_turn(box.axis) * v;
      points.push_back({{at.x(), at.y(), height_m}, Vec3d::UnitZ(), kStep_m * kStep_m});
    }
  }
  return points;
}

LabelledSurface with_table(std::vector<LabelledPoint> points) {
  const LabelSet labels = load_label_set("scannet20");
  LabelledSurface surface;
  surface.voxel_m = 0.024;
  surface.class_of = {{kTable, labels.find(std::string_view("table"))->id},
                      {kVase, labels.find(std::string_view("otherfurniture"))->id}};
  surface.of_object[kTable] = std::move(points);
  return surface;
}

Polygon flat(const std::vector<Vec3d>& polygon) {
  Polygon result;
  for (const Vec3d& p : polygon) result.push_back(p.head<2>());
  return result;
}

const FlatBox kTop{{1, 2}, {std::cos(0.4), std::sin(0.4)}, {1.2, 0.8}};

TEST(TableTops, TheTopIsTheHighestLargeLevel) {
  std::vector<LabelledPoint> points = level(kTop, 0.74);
  const auto shelf = level(kTop, 0.3);
  points.insert(points.end(), shelf.begin(), shelf.end());
  const auto tops = find_table_tops(with_table(points), load_label_set("scannet20"), nothing_is_empty);
  ASSERT_EQ(tops.size(), 1U);
  EXPECT_NEAR(tops[0].height_m, 0.74, 0.005);
  EXPECT_GT(intersection_over_union(flat(tops[0].polygon), corners(kTop)), 0.97);
  EXPECT_EQ(tops[0].object, kTable);
}

TEST(TableTops, WhatStandsOnATableTakesRoomButNotShape) {
  std::vector<LabelledPoint> points;
  const FlatBox vase{kTop.center + kTop.axis * 0.3, kTop.axis, {0.2, 0.2}};
  for (const LabelledPoint& p : level(kTop, 0.74)) {
    if (!contains(corners(vase), p.at.head<2>())) points.push_back(p);
  }
  LabelledSurface surface = with_table(points);
  surface.of_object[kVase] = level(vase, 0.9);
  const auto tops = find_table_tops(surface, load_label_set("scannet20"), nothing_is_empty);
  ASSERT_EQ(tops.size(), 1U);
  EXPECT_GT(intersection_over_union(flat(tops[0].polygon), corners(kTop)), 0.97);
  ASSERT_GE(tops[0].free_rectangles.size(), 2U);
  for (const auto& rectangle : tops[0].free_rectangles) {
    EXPECT_LT(intersection_over_union(flat(rectangle), corners(vase)), 0.02);
  }
  // The largest runs over the whole depth, on the side where the vase is not.
  EXPECT_NEAR(signed_area(flat(tops[0].free_rectangles[0])), 0.8 * 0.8, 0.06);
}

TEST(TableTops, ATopAroundACornerIsNoRectangle) {
  std::vector<LabelledPoint> points = level({{0, 0}, {1, 0}, {2, 0.6}}, 0.72);
  const auto wing = level({{0.7, -0.8}, {0, 1}, {1, 0.6}}, 0.72);
  points.insert(points.end(), wing.begin(), wing.end());
  const auto tops = find_table_tops(with_table(points), load_label_set("scannet20"),
                                    [](const Vec3d& p) { return p.x() < 0.38 && p.y() < -0.32; });
  ASSERT_EQ(tops.size(), 1U);
  EXPECT_NEAR(tops[0].area_m2, 2 * 0.6 + 0.6 * 1.0, 0.15);
}

TEST(TableTops, CabinetsAndCrumbsHaveNone) {
  LabelledSurface surface = with_table(level(kTop, 0.74));
  surface.class_of[kTable] = load_label_set("scannet20").find(std::string_view("cabinet"))->id;
  EXPECT_TRUE(find_table_tops(surface, load_label_set("scannet20"), nothing_is_empty).empty());
  EXPECT_TRUE(find_table_tops(with_table(level({{0, 0}, {1, 0}, {0.1, 0.1}}, 0.7)), load_label_set("scannet20"), nothing_is_empty)
                  .empty());
}

// Every rectangle of cells, one by one.
double largest_by_trying(const Polygon& polygon, const std::vector<Vec2d>& taken, double cell_m) {
  const auto free = [&](int x, int y) {
    const Vec2d middle((x + 0.5) * cell_m, (y + 0.5) * cell_m);
    if (!contains(polygon, middle)) return false;
    for (const Vec2d& t : taken) {
      if (std::floor(t.x() / cell_m) == x && std::floor(t.y() / cell_m) == y) return false;
    }
    return true;
  };
  constexpr int kSide = 12;
  double best = 0;
  for (int x0 = 0; x0 < kSide; ++x0) {
    for (int y0 = 0; y0 < kSide; ++y0) {
      for (int x1 = x0 + 1; x1 <= kSide; ++x1) {
        for (int y1 = y0 + 1; y1 <= kSide; ++y1) {
          bool all = true;
          for (int x = x0; x < x1 && all; ++x) {
            for (int y = y0; y < y1 && all; ++y) all = free(x, y);
          }
          if (all) best = std::max(best, (x1 - x0) * (y1 - y0) * cell_m * cell_m);
        }
      }
    }
  }
  return best;
}

TEST(FreeRectangles, TheFirstIsTheLargestThereIs) {
  const Polygon square = {{0, 0}, {1.2, 0}, {1.2, 1.2}, {0, 1.2}};
  for (int seed = 1; seed < 12; ++seed) {
    std::vector<Vec2d> taken;
    for (int i = 0; i < 6; ++i)
      taken.emplace_back(0.05 + 0.1 * ((seed * 7 + i * 5) % 12), 0.05 + 0.1 * ((seed * 3 + i * 11) % 12));
    const auto rectangles = free_rectangles(square, taken, 0.1, 0.1);
    ASSERT_FALSE(rectangles.empty());
    EXPECT_NEAR(signed_area(rectangles[0]), largest_by_trying(square, taken, 0.1), 1e-9) << seed;
    for (const Vec2d& t : taken) EXPECT_FALSE(contains(rectangles[0], t));
  }
}

}  // namespace
}  // namespace panoptic
