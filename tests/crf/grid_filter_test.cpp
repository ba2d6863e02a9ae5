// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/grid_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/crf/crf_graphs.h"

namespace panoptic {
namespace {

using test::random_graph;
using test::share;

// The largest relative difference between the filter and the sum over all pairs, for one row width.
double difference(const std::vector<GridPoint>& points, float sigma, RowWidth row_width) {
  const auto width = static_cast<std::size_t>(row_width);
  const std::size_t stride = width + 3;
  std::mt19937 random(9);
  std::vector<float> in(points.size() * stride);
  std::vector<float> scale(points.size());
  for (float& value : in) value = 0.5F + share(random);
  for (float& value : scale) value = 0.5F + share(random);
  std::vector<float> out(points.size() * width, -1);
  GridScratch scratch;
  const auto take = [&](std::span<const std::uint32_t> taken, const float* sums) {
    for (std::size_t k = 0; k < taken.size(); ++k) std::copy_n(sums + k * width, width, out.data() + taken[k] * width);
  };
  GridFilter(points, sigma).apply({in.data(), stride, scale.data()}, row_width, scratch, {}, take);
  double most = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<double> expected(width, 0);
    for (std::size_t j = 0; j < points.size(); ++j) {
      const GridPoint& a = points[i];
      const GridPoint& b = points[j];
      const double squares = std::pow(a.x - b.x, 2) + std::pow(a.y - b.y, 2) + std::pow(a.z - b.z, 2);
      const double weight = std::exp(-squares / (2.0 * sigma * sigma)) * scale[j];
      for (std::size_t c = 0; c < width; ++c) expected[c] += weight * in[j * stride + c];
    }
    for (std::size_t c = 0; c < width; ++c) most = std::max(most, std::abs(out[i * width + c] / expected[c] - 1));
  }
  return most;
}

TEST(GridFilter, EqualsTheSumOverAllPairsButForTheTruncation) {
  for (const float sigma : {0.6F, 2.083F, 5.0F}) {
    for (const RowWidth width : {RowWidth::k8, RowWidth::k16, RowWidth::k24, RowWidth::k32}) {
      EXPECT_LT(difference(random_graph(10, 0.6F, 2, 1).points, sigma, width), 1e-3);
      EXPECT_LT(difference(random_graph(30, 0.01F, 2, 2).points, sigma, width), 1e-3);
      EXPECT_LT(difference(test::sheet_graph({.side = 15}, 3).points, sigma, width), 1e-3);
    }
  }
}

TEST(GridFilter, ReachesAcrossGapsToTheBordersOfTheBox) {
  for (int d = 1; d <= 7; ++d) {
    EXPECT_LT(difference({{0, 0, 0}, {d, 0, 0}}, 2.083F, RowWidth::k8), 1e-6);
    EXPECT_LT(difference({{0, 0, 0}, {0, d, 0}}, 2.083F, RowWidth::k8), 1e-6);
    EXPECT_LT(difference({{0, 0, 0}, {0, 0, d}}, 2.083F, RowWidth::k8), 1e-6);
    EXPECT_LT(difference({{6, 0, 0}, {4, d, 0}, {-d, 0, 2}}, 2.083F, RowWidth::k8), 1e-3);
  }
  // More than a word of bits along x.
  EXPECT_LT(difference({{-70, 0, 0}, {-5, 0, 0}, {0, 0, 0}, {64, 0, 0}, {-65, 1, 0}}, 2.083F, RowWidth::k8), 1e-3);
}

TEST(GridFilter, ForASheetThereAreFewPlacesBetween) {
  const auto points = test::sheet_graph({.side = 60}, 1).points;
  EXPECT_LT(GridFilter(points, 2.083F).places_between(), 5 * points.size());
}

TEST(BitGrid, DilationAddsWhatIsWithinTheRadiusAlsoAtTheBorder) {
  for (const int axis : {0, 1, 2}) {
    for (const int radius : {1, 3, 8, 70}) {
      BitGrid grid({{0, 0, 0}, {90, 90, 90}});
      grid.set({2, 2, 2});
      grid.set({80, 80, 80});
      grid.dilate(axis, radius);
      for (int t = 0; t < 90; ++t) {
        const auto point = [&](int other) {
          return GridPoint{axis == 0 ? t : other, axis == 1 ? t : other, axis == 2 ? t : other};
        };
        ASSERT_EQ(grid.contains(point(2)), std::abs(t - 2) <= radius) << axis << ' ' << radius << ' ' << t;
        ASSERT_EQ(grid.contains(point(80)), std::abs(t - 80) <= radius);
      }
    }
  }
}

}  // namespace
}  // namespace panoptic
