// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/rasterizer.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <utility>

#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr Rgb kRed = {200, 0, 0};
constexpr Rgb kBlue = {0, 0, 200};

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

DrawnVertex at(float u, float v, float z, const Rgb& color = kRed, int label = 1) {
  return {{u, v, 1 / z}, 1, color, static_cast<std::uint16_t>(label)};
}

Drawing drawing_of(std::vector<DrawnVertex> vertices, const Triangles& triangles, bool flat = true) {
  return {64, 48, flat, std::move(vertices), &triangles};
}

std::size_t covered(const Picture& picture) {
  std::size_t count = 0;
  for (const std::uint8_t c : picture.covered.pixels()) count += c;
  return count;
}

TEST(Rasterizer, FillsExactlyThePixelsOfASquare) {
  // From the left edge of pixel 10 to the right edge of pixel 19, rows 5 to 24; counter-clockwise on the screen.
  const Triangles triangles = {{0, 1, 2}, {0, 2, 3}};
  const Picture picture =
      rasterize(drawing_of({at(9.5F, 4.5F, 2), at(9.5F, 24.5F, 2), at(19.5F, 24.5F, 2), at(19.5F, 4.5F, 2)}, triangles));
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      const bool inside = u >= 10 && u <= 19 && v >= 5 && v <= 24;
      ASSERT_EQ(picture.covered(u, v), inside ? 1 : 0) << u << " " << v;
      ASSERT_EQ(picture.label(u, v), inside ? 1 : 0);
      if (inside) {
        ASSERT_EQ(picture.color(u, v), kRed) << u << " " << v;
      }
    }
  }
}

TEST(Rasterizer, SurfacesSeenFromBehindAreNotThere) {
  const Triangles triangles = {{0, 2, 1}};
  EXPECT_EQ(covered(rasterize(drawing_of({at(5, 5, 2), at(5, 40, 2), at(50, 40, 2)}, triangles))), 0U);
}

TEST(Rasterizer, TheNearerSurfaceWinsInAnyOrder) {
  const std::vector<DrawnVertex> vertices = {at(5, 5, 3),           at(5, 40, 3),           at(50, 40, 3),
                                             at(5, 5, 2, kBlue, 2), at(5, 40, 2, kBlue, 2), at(50, 40, 2, kBlue, 2)};
  for (const Triangles& triangles : {Triangles{{0, 1, 2}, {3, 4, 5}}, Triangles{{3, 4, 5}, {0, 1, 2}}}) {
    const Picture picture = rasterize(drawing_of(vertices, triangles));
    EXPECT_EQ(picture.label(10, 30), 2);
    EXPECT_EQ(picture.color(10, 30), kBlue);
  }
}

TEST(Rasterizer, DepthIsInterpolatedInPerspective) {
  // A plane from z = 1 at the left to z = 10 at the right, half way across the screen z is 20 / 11, against one at z = 2.
  const Triangles triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  const Picture picture = rasterize(drawing_of({at(0, 0, 1), at(0, 47, 1), at(63, 47, 10), at(63, 0, 10), at(0, 0, 2, kBlue, 2),
                                                at(0, 47, 2, kBlue, 2), at(63, 47, 2, kBlue, 2), at(63, 0, 2, kBlue, 2)},
                                               triangles));
  EXPECT_EQ(picture.label(31, 20), 1);  // 1.8 m
  EXPECT_EQ(picture.label(38, 20), 2);  // 2.2 m
}

TEST(Rasterizer, NeighboursLeaveNoGap) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> where(10, 40);
  for (int i = 0; i < 50; ++i) {
    const Triangles triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    const Picture picture = rasterize(
        drawing_of({at(2, 2, 2), at(2, 44, 2), at(60, 44, 2), at(60, 2, 2), at(where(random), where(random), 2)}, triangles));
    for (int v = 3; v < 44; ++v) {
      for (int u = 3; u < 60; ++u) ASSERT_EQ(picture.color(u, v), kRed) << i << ": " << u << " " << v;
    }
  }
}

TEST(Rasterizer, BlendsColorsUnlessFlat) {
  const Triangles triangles = {{0, 1, 2}};
  const std::vector<DrawnVertex> vertices = {at(0, 0, 2, kRed, 1), at(0, 40, 2, kRed, 1), at(60, 40, 2, kBlue, 2)};
  const Rgb blended = rasterize(drawing_of(vertices, triangles, false)).color(30, 30);
  EXPECT_NEAR(blended.r, 100, 4);
  EXPECT_NEAR(blended.b, 100, 4);
  const Picture flat = rasterize(drawing_of(vertices, triangles, true));
  EXPECT_EQ(flat.color(30, 30), kRed);
  EXPECT_EQ(flat.label(50, 38), 1);
}

TEST(Rasterizer, LeavesOutWhatIsBehindTheCameraOrFarOutside) {
  const Triangles triangles = {{0, 1, 2}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const DrawnVertex& odd : {at(50, 40, -1), at(5e8F, 40, 2), at(nan, 40, 2), at(50, -3e38F, 2), at(50, 40, nan)}) {
    EXPECT_EQ(covered(rasterize(drawing_of({at(5, 5, 2), at(5, 40, 2), odd}, triangles))), 0U);
  }
}

TEST(Rasterizer, CutsOffWhatReachesOutOfThePicture) {
  const Triangles triangles = {{0, 1, 2}};
  const Picture picture = rasterize(drawing_of({at(-5000, -5000, 2), at(-5000, 9000, 2), at(9000, 9000, 2)}, triangles));
  EXPECT_EQ(picture.label(0, 47), 1);
  EXPECT_EQ(picture.label(63, 0), 0);  // beyond the diagonal
}

TEST(Rasterizer, OneThreadAndTwoDrawTheSame) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> position(-10, 70);
  std::vector<DrawnVertex> vertices;
  Triangles triangles;
  for (std::uint32_t i = 0; i < 60000; ++i) {
    const float u = position(random);
    const float v = position(random);
    const float z = 1 + position(random) / 40;
    for (const auto& [du, dv] : {std::pair{0.0F, 0.0F}, {0.5F, 4.0F}, {3.0F, 2.0F}}) {
      vertices.push_back(at(u + du, v + dv, z, i % 2 == 0 ? kRed : kBlue, static_cast<int>(i % 5)));
    }
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  set_thread_count(1);
  const Picture one = rasterize(drawing_of(vertices, triangles));
  set_thread_count(2);
  const Picture two = rasterize(drawing_of(vertices, triangles));
  set_thread_count(0);
  EXPECT_EQ(one.color, two.color);
  EXPECT_EQ(one.label, two.label);
  EXPECT_GT(covered(one), 2000U);
}

}  // namespace
}  // namespace panoptic
