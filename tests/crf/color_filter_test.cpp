// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/color_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/crf/crf_graphs.h"

namespace panoptic {
namespace {

using test::share;

struct Sums {
  std::vector<double> expected;
  std::vector<double> filtered;
};

Sums sums_of(const CrfGraph& graph) {
  std::mt19937 random(4);
  std::vector<float> in(graph.size() * 8, 0);
  std::vector<float> scale(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    in[i * 8 + 5] = share(random);
    scale[i] = 0.5F + share(random);
  }
  const ColorFilter filter(graph.points, graph.colors, {2.083F, 20}, {});
  ColorScratch scratch;
  const float* rows = filter.apply({in.data(), 8, scale.data()}, RowWidth::k8, scratch, {});
  Sums sums;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    double expected = 0;
    for (std::size_t j = 0; j < graph.size(); ++j) {
      const GridPoint& a = graph.points[i];
      const GridPoint& b = graph.points[j];
      double color = 0;
      for (std::size_t c = 0; c < 3; ++c) color += std::pow(graph.colors[i][c] - graph.colors[j][c], 2);
      const double squares = std::pow(a.x - b.x, 2) + std::pow(a.y - b.y, 2) + std::pow(a.z - b.z, 2);
      expected += std::exp(-squares / (2 * 2.083 * 2.083) - color / 800) * scale[j] * in[j * 8 + 5];
    }
    sums.expected.push_back(expected);
    sums.filtered.push_back(double{rows[filter.cluster_of()[i] * 8 + 5]});
  }
  return sums;
}

TEST(ColorFilter, IsNearTheSumOverAllPairsOnASurface) {
  const Sums sums = sums_of(test::sheet_graph({.side = 30}, 3));
  double error = 0;
  double total = 0;
  for (std::size_t i = 0; i < sums.expected.size(); ++i) {
    error += std::abs(sums.filtered[i] - sums.expected[i]);
    total += sums.expected[i];
  }
  EXPECT_LT(error / total, 0.15);
}

TEST(ColorFilter, IsExactWhereNoTwoVoxelsAreAlike) {
  CrfGraph graph = test::random_graph(40, 0.004F, 2, 1);
  for (std::size_t i = 0; i < graph.size(); ++i) graph.colors[i] = {static_cast<float>(i % 2) * 100, 0, 0};
  for (GridPoint& p : graph.points) p = {3 * p.x, 3 * p.y, 3 * p.z};
  const Sums sums = sums_of(graph);
  for (std::size_t i = 0; i < sums.expected.size(); ++i) EXPECT_NEAR(sums.filtered[i], sums.expected[i], 0.02);
}

TEST(ColorFilter, KeepsColoursApart) {
  const std::vector<GridPoint> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const std::vector<VoxelColor> colors = {{0, 0, 0}, {200, 0, 0}, {0, 0, 0}};
  std::vector<float> in(24, 0);
  in[8] = 1;  // the middle voxel
  const ColorFilter filter(points, colors, {2.083F, 20}, {});
  ColorScratch scratch;
  const float* rows = filter.apply({in.data(), 8, nullptr}, RowWidth::k8, scratch, {});
  EXPECT_EQ(rows[filter.cluster_of()[0] * 8], 0);
  EXPECT_EQ(rows[filter.cluster_of()[1] * 8], 1);
  EXPECT_EQ(rows[filter.cluster_of()[2] * 8], 0);
}

}  // namespace
}  // namespace panoptic
