// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/surface_metrics.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "panoptic/base/nearest_points.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

// A square of the given side at height z, in cells x cells x 2 triangles.
struct Square {
  Square(float side_m, float z, std::uint32_t cells) {
    for (std::uint32_t y = 0; y <= cells; ++y) {
      for (std::uint32_t x = 0; x <= cells; ++x) {
        positions.emplace_back(side_m * static_cast<float>(x) / static_cast<float>(cells),
                               side_m * static_cast<float>(y) / static_cast<float>(cells), z);
      }
    }
    for (std::uint32_t y = 0; y < cells; ++y) {
      for (std::uint32_t x = 0; x < cells; ++x) {
        const std::uint32_t i = y * (cells + 1) + x;
        triangles.push_back({i, i + 1, i + cells + 2});
        triangles.push_back({i, i + cells + 2, i + cells + 1});
      }
    }
  }
  Surface surface() const { return {positions, triangles}; }

  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

SurfaceScores compare(const Surface& map, const Surface& truth) {
  SurfaceMetrics metrics;
  metrics.add(map, truth);
  return metrics.scores();
}

TEST(SampleSurface, SpreadsPointsByAreaAndNotByTriangles) {
  // One triangle for x < 1, four hundred for x in 1..2 of the same area.
  Square fine(1, 0, 14);
  for (Vec3f& p : fine.positions) p.x() += 1;
  const auto base = static_cast<std::uint32_t>(fine.positions.size());
  fine.positions.insert(fine.positions.end(), {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  fine.triangles.push_back({base, base + 1, base + 2});
  fine.triangles.push_back({base, base + 2, base + 3});
  const std::vector<Vec3f> points = sample_surface(fine.surface(), 20000);
  ASSERT_EQ(points.size(), 20000U);
  std::array<std::array<int, 2>, 4> quarters{};  // of x in steps of one half, by y
  for (const Vec3f& p : points) {
    ASSERT_TRUE(p.x() >= 0 && p.x() <= 2 && p.y() >= 0 && p.y() <= 1 && p.z() == 0);
    ++quarters[std::min<std::size_t>(3, static_cast<std::size_t>(2 * p.x()))][p.y() < 0.5F ? 0 : 1];
  }
  for (const auto& column : quarters) {
    for (const int count : column) EXPECT_NEAR(count, 2500, 75);
  }
}

TEST(SampleSurface, GivesNoPointsWithoutArea) {
  const std::vector<std::array<std::uint32_t, 3>> degenerate = {{0, 1, 1}};
  EXPECT_TRUE(sample_surface({{{0, 0, 0}, {1, 0, 0}}, degenerate}, 100).empty());
  EXPECT_TRUE(sample_surface({}, 100).empty());
}

TEST(SurfaceMetrics, MeasuresTheDistanceOfParallelPlanes) {
  const Square low(1, 0, 3);
  const Square high(1, 0.03F, 20);
  const SurfaceScores scores = compare(low.surface(), high.surface());
  EXPECT_NEAR(scores.accuracy_m.value(), 0.03, 0.002) << "a little more, for the points' spacing";
  EXPECT_NEAR(scores.completion_m.value(), 0.03, 0.002);
  EXPECT_EQ(scores.at[0].threshold_m, 0.05);
  EXPECT_EQ(scores.at[0].f_score, 1);
  EXPECT_EQ(scores.at[1].threshold_m, 0.025);
  EXPECT_EQ(scores.at[1].f_score, 0);
}

TEST(SurfaceMetrics, TellsMissingSurfaceFromSurfaceTooMuch) {
  const Square small(1, 0, 5);
  const Square large(2, 0, 5);
  const SurfaceScores part = compare(small.surface(), large.surface());
  EXPECT_EQ(part.at[0].precision, 1);
  EXPECT_NEAR(part.at[0].recall.value(), 1.05 * 1.05 / 4, 0.01);
  EXPECT_NEAR(part.at[0].f_score.value(), 2 * *part.at[0].recall / (1 + *part.at[0].recall), 1e-12);
  EXPECT_LT(part.accuracy_m.value(), 0.02);
  EXPECT_GT(part.completion_m.value(), 0.2);
  const SurfaceScores much = compare(large.surface(), small.surface());
  EXPECT_EQ(much.at[0].recall, 1);
  EXPECT_EQ(much.at[0].precision, part.at[0].recall);
}

TEST(SurfaceMetrics, CountsAnEmptyMapAsAllMissed) {
  const Square truth(1, 0, 5);
  const SurfaceScores scores = compare({}, truth.surface());
  EXPECT_FALSE(scores.accuracy_m.has_value());
  EXPECT_FALSE(scores.completion_m.has_value());
  EXPECT_FALSE(scores.at[0].precision.has_value()) << "nothing is wrong where nothing is";
  EXPECT_EQ(scores.at[0].recall, 0);
  EXPECT_EQ(scores.at[0].f_score, 0);
}

TEST(SurfaceMetrics, OfATruthWithoutSurfaceHaveNoValues) {
  const Square map(1, 0, 5);
  const SurfaceScores scores = compare(map.surface(), {});
  for (const ThresholdScores& at : scores.at) {
    EXPECT_FALSE(at.precision.has_value());
    EXPECT_FALSE(at.recall.has_value());
    EXPECT_FALSE(at.f_score.has_value());
  }
  EXPECT_EQ(scores.at[0].threshold_m, 0.05);
}

TEST(SurfaceMetrics, IsTheSameAtAnyThreadCount) {
  const Square a(1, 0, 7);
  const Square b(1.1F, 0.01F, 9);
  set_thread_count(1);
  const SurfaceScores one = compare(a.surface(), b.surface());
  set_thread_count(4);
  const SurfaceScores four = compare(a.surface(), b.surface());
  set_thread_count(0);
  EXPECT_EQ(one.accuracy_m, four.accuracy_m);
  EXPECT_EQ(one.completion_m, four.completion_m);
}

TEST(NearestPoints, FindsWhatASearchThroughAllFindsAndTheFirstOfEquals) {
  std::mt19937_64 random(8);
  std::vector<Vec3f> points;
  for (int i = 0; i < 3000; ++i) {  // on a coarse lattice: many at one place, many ties
    points.emplace_back(static_cast<float>(random() % 12), static_cast<float>(random() % 12), static_cast<float>(random() % 12));
  }
  const NearestPoints nearest(points);
  for (int i = 0; i < 500; ++i) {
    const Vec3f query(static_cast<float>(random() % 27) / 2, static_cast<float>(random() % 27) / 2,
                      static_cast<float>(random() % 27) / 2);
    std::uint32_t best = 0;
    for (std::uint32_t k = 1; k < points.size(); ++k) {
      if ((points[k] - query).squaredNorm() < (points[best] - query).squaredNorm()) best = k;
    }
    const auto found = nearest.nearest(query);
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(found->index, best);
    EXPECT_NEAR(found->distance_m, (points[best] - query).norm(), 1e-6);
  }
  EXPECT_FALSE(NearestPoints({}).nearest({0, 0, 0}).has_value());
}

}  // namespace
}  // namespace panoptic
