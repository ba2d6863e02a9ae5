// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/mean_field.h"

#include <gtest/gtest.h>

#include "panoptic/parallel.h"
#include "tests/crf/crf_graphs.h"

namespace panoptic {
namespace {

using test::argmax;
using test::naive_mean_field;
using test::random_graph;
using test::sheet_graph;
using test::strip_graph;

constexpr int kIterations = 5;
constexpr MeanFieldSettings kPaper{10, 15, 2.083F, 20};
constexpr MeanFieldSettings kPositionOnly{0, 15, 2.083F, 20};

struct Difference {
  double most = 0;   // of marginals
  double agree = 0;  // share of voxels with the same best label
};

Difference difference(const CrfGraph& graph, const MeanFieldSettings& settings) {
  const auto expected = naive_mean_field(graph, settings, kIterations);
  MeanFieldScratch scratch;
  MeanField field(graph, settings, scratch);
  for (int i = 0; i < kIterations; ++i) field.iterate();
  Difference d;
  for (std::size_t v = 0; v < graph.size(); ++v) {
    for (std::size_t l = 0; l < graph.label_count; ++l)
      d.most = std::max(d.most, std::abs(expected[v][l] - field.marginal(v, l)));
    d.agree += field.best(v).label == argmax(expected[v]) ? 1.0 : 0.0;
  }
  d.agree /= static_cast<double>(graph.size());
  return d;
}

TEST(MeanField, WithThePositionKernelAloneMarginalsAreThoseOfTheDefinition) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    EXPECT_LT(difference(random_graph(13, 0.5F, 5, seed), kPositionOnly).most, 1e-3);
    EXPECT_LT(difference(random_graph(28, 0.05F, 19, seed), kPositionOnly).most, 1e-3);
    EXPECT_LT(difference(sheet_graph({.side = 14, .patch = 5}, seed), kPositionOnly).most, 1e-3);
  }
}

TEST(MeanField, WithBothKernelsNearlyAllLabelsAreThoseOfTheDefinition) {
  for (const unsigned seed : {1U, 2U}) {
    EXPECT_GE(difference(random_graph(13, 0.5F, 5, seed), kPaper).agree, 0.99);
    EXPECT_GE(difference(random_graph(28, 0.05F, 19, seed), kPaper).agree, 0.99);
    EXPECT_GE(difference(sheet_graph({.side = 14, .patch = 5}, seed), kPaper).agree, 0.99);
    EXPECT_GE(difference(sheet_graph({.side = 14, .patch = 5, .labels = 8, .noise = 0.6F}, seed), kPaper).agree, 0.99);
  }
}

TEST(MeanField, LabelsThatShareColumnsHaveTheMarginalsOfTheDefinitionToo) {
  for (const unsigned seed : {1U, 2U}) {
    // In one group of columns, in one of 16 and, since they are side by side, in two.
    for (const auto& [labels, patch] : {std::pair<std::size_t, int>{20, 13}, {52, 5}, {130, 2}}) {
      const CrfGraph graph = strip_graph({.length = 260, .patch = patch, .labels = labels}, seed);
      const Difference d = difference(graph, kPositionOnly);
      EXPECT_LT(d.most, 1e-3) << labels;
      EXPECT_GE(difference(graph, kPaper).agree, 0.99) << labels;
    }
  }
}

TEST(MeanField, NoiseOnASheetOfPatchesIsSmoothedAway) {
  const CrfGraph noisy = sheet_graph({}, 7);
  const CrfGraph clean = sheet_graph({.noise = 0}, 7);
  MeanFieldScratch scratch;
  MeanField field(noisy, kPaper, scratch);
  for (int i = 0; i < kIterations; ++i) field.iterate();
  std::size_t before = 0;
  std::size_t after = 0;
  for (std::size_t v = 0; v < noisy.size(); ++v) {
    before += noisy.labels[v] != clean.labels[v] ? 1 : 0;
    after += field.best(v).label != clean.labels[v] ? 1 : 0;
  }
  EXPECT_GT(before, noisy.size() / 6);
  EXPECT_LT(after, noisy.size() / 100);
}

TEST(MeanField, RunsAloneAndOnAllThreadsToTheSameBits) {
  for (const CrfGraph& graph : {sheet_graph({.labels = 21}, 3), strip_graph({.length = 4000, .labels = 21}, 3)}) {
    MeanFieldScratch scratch;
    MeanFieldScratch other_scratch;
    MeanField alone(graph, kPaper, scratch);
    set_thread_count(3);
    MeanField together(graph, kPaper, other_scratch, {.parallel = true});
    for (int i = 0; i < 2; ++i) alone.iterate(), together.iterate();
    set_thread_count(0);
    for (std::size_t v = 0; v < graph.size(); ++v) {
      for (std::size_t l = 0; l < 21; ++l) ASSERT_EQ(alone.marginal(v, l), together.marginal(v, l));
    }
  }
}

void expect_probabilities(const CrfGraph& graph) {
  MeanFieldScratch scratch;
  MeanField field(graph, kPaper, scratch);
  for (int i = 0; i < kIterations; ++i) field.iterate();
  for (std::size_t v = 0; v < graph.size(); ++v) {
    float sum = 0;
    for (std::size_t l = 0; l < graph.label_count; ++l) {
      ASSERT_GE(field.marginal(v, l), 0.0F);
      sum += field.marginal(v, l);
    }
    ASSERT_NEAR(sum, 1, 1e-4);
  }
}

// A third of the voxels says nothing: all labels are as probable there, whichever column they have.
CrfGraph with_gaps(CrfGraph graph) {
  for (std::size_t v = 0; v < graph.size(); v += 3) graph.labels[v] = CrfGraph::kNoLabel;
  return graph;
}

TEST(MeanField, VoxelsOfWhichNothingIsKnownHaveTheMarginalsOfTheDefinition) {
  for (const unsigned seed : {1U, 2U}) {
    EXPECT_LT(difference(with_gaps(random_graph(13, 0.5F, 5, seed)), kPositionOnly).most, 1e-3);
    EXPECT_LT(difference(with_gaps(random_graph(28, 0.05F, 19, seed)), kPositionOnly).most, 1e-3);
    EXPECT_GE(difference(with_gaps(sheet_graph({.side = 14, .patch = 5}, seed)), kPaper).agree, 0.99);
    const CrfGraph strip = with_gaps(strip_graph({}, seed));
    ASSERT_TRUE(LabelColumns(strip.points, strip.labels, strip.label_count, 9).shared());
    EXPECT_LT(difference(strip, kPositionOnly).most, 1e-3) << "labels that share columns";
  }
}

TEST(MeanField, OddGraphsGiveProbabilitiesToo) {
  CrfGraph one_voxel{{{-5, 3, 1 << 24}}, {{0, 0, 0}}, {0}, {0.5F}, 2, 2};
  expect_probabilities(one_voxel);
  CrfGraph one_label = sheet_graph({.side = 12, .labels = 1}, 1);
  expect_probabilities(one_label);
  CrfGraph one_color = sheet_graph({.side = 12}, 1);
  std::fill(one_color.colors.begin(), one_color.colors.end(), VoxelColor{255, 255, 255});
  expect_probabilities(one_color);
  CrfGraph certain = sheet_graph({.side = 12, .labels = 2}, 1);
  std::fill(certain.probabilities.begin(), certain.probabilities.end(), 0.999999F);
  certain.all_labels = 65535;
  expect_probabilities(certain);
  CrfGraph far_apart{{{-16'000'000, 0, 0}, {-14'000'000, 0, 0}}, {{0, 0, 0}, {9, 9, 9}}, {0, 1}, {0.5F, 0.9F}, 2, 2};
  expect_probabilities(far_apart);
  CrfGraph labelled_by_others = sheet_graph({.side = 12, .labels = 3}, 1);
  std::fill(labelled_by_others.labels.begin(), labelled_by_others.labels.end(), CrfGraph::kOtherLabel);
  labelled_by_others.all_labels = 1000;
  expect_probabilities(labelled_by_others);
  CrfGraph far_labels = strip_graph({.labels = 20}, 1);
  expect_probabilities(far_labels);
  far_labels.probabilities.assign(far_labels.size(), 0.999999F);
  expect_probabilities(far_labels);
}

}  // namespace
}  // namespace panoptic
