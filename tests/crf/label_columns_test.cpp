// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/label_columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "tests/crf/crf_graphs.h"

namespace panoptic {
namespace {

constexpr std::int32_t kReach = 9;

bool in_reach(const GridPoint& a, const GridPoint& b) {
  return std::abs(a.x - b.x) <= kReach && std::abs(a.y - b.y) <= kReach && std::abs(a.z - b.z) <= kReach;
}

LabelColumns columns_of(const CrfGraph& g) { return {g.points, g.labels, g.label_count, kReach}; }

TEST(LabelColumns, EveryLabelInReachOfAVoxelHasAColumnOfItsOwnThere) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    CrfGraph graph = test::strip_graph({.length = 300, .side = 2, .patch = 11, .labels = 27}, seed);
    for (GridPoint& p : graph.points) p.x -= 155;  // tiles on both sides of zero
    const LabelColumns columns = columns_of(graph);
    ASSERT_TRUE(columns.shared());
    for (std::size_t i = 0; i < graph.size(); ++i) {
      for (std::size_t j = 0; j < graph.size(); ++j) {
        if (!in_reach(graph.points[i], graph.points[j])) continue;
        const std::uint16_t label = graph.labels[j];
        ASSERT_EQ(columns.label_at(columns.column_of(label), graph.points[i]), label);
      }
    }
  }
}

TEST(LabelColumns, FarApartLabelsShareThem) {
  const CrfGraph graph = test::strip_graph({.length = 400, .side = 2, .patch = 10, .labels = 40}, 1);
  EXPECT_LE(columns_of(graph).count(), 8U);
}

TEST(LabelColumns, WhereTheyWouldSaveNoGroupOfEightEachLabelHasItsOwn) {
  const CrfGraph few = test::strip_graph({.length = 400, .side = 2, .patch = 50, .labels = 8}, 1);
  const CrfGraph everywhere = test::random_graph(13, 0.5F, 19, 1);
  for (const CrfGraph* graph : {&few, &everywhere}) {
    const LabelColumns columns = columns_of(*graph);
    EXPECT_FALSE(columns.shared());
    ASSERT_EQ(columns.count(), graph->label_count);
    for (std::uint16_t label = 0; label < graph->label_count; ++label) {
      EXPECT_EQ(columns.column_of(label), label);
      EXPECT_EQ(columns.label_at(label, graph->points[0]), label);
    }
  }
}

TEST(LabelColumns, LabelsThatAreNotAmongThoseCountedTakeNoPlace) {
  CrfGraph graph = test::strip_graph({.length = 400, .side = 2, .patch = 10, .labels = 40}, 1);
  for (std::uint16_t& label : graph.labels) label = label % 2 == 0 ? label : CrfGraph::kOtherLabel;
  EXPECT_LE(columns_of(graph).count(), 8U);
}

TEST(LabelColumns, ReachAcrossTheWholeRangeOfCoordinates) {
  std::vector<GridPoint> points;
  std::vector<std::uint16_t> labels;
  for (std::int32_t l = 0; l < 9; ++l) {
    points.push_back({-4'000'000 + 1'000'000 * l, 7, -3});
    labels.push_back(static_cast<std::uint16_t>(l));
  }
  const LabelColumns columns(points, labels, 9, kReach);
  ASSERT_EQ(columns.count(), 1U);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(columns.label_at(0, points[i]), labels[i]);
}

}  // namespace
}  // namespace panoptic
