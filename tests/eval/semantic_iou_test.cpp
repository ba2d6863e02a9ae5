// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/semantic_iou.h"

#include <gtest/gtest.h>

#include "panoptic/eval/benchmark_classes.h"
#include "tests/eval/random_scenes.h"

namespace panoptic {
namespace {

std::optional<double> naive_iou(const std::vector<VertexLabels>& truths, const std::vector<VertexLabels>& predictions,
                                ClassId c) {
  double tp = 0;
  double all = 0;
  for (std::size_t s = 0; s < truths.size(); ++s) {
    for (std::size_t v = 0; v < truths[s].class_id.size(); ++v) {
      const ClassId t = truths[s].class_id[v];
      const ClassId p = predictions[s].class_id[v];
      if (!benchmark_index(t)) continue;
      tp += t == c && p == c ? 1 : 0;
      all += t == c || p == c ? 1 : 0;
    }
  }
  if (all == 0) return std::nullopt;
  return tp / all;
}

TEST(SemanticIou, EqualsTheNaiveCountOverSeveralScenes) {
  std::mt19937_64 random(9);
  for (int round = 0; round < 20; ++round) {
    std::vector<VertexLabels> truths;
    std::vector<VertexLabels> predictions;
    SemanticIou metric;
    for (int s = 0; s < 3; ++s) {
      truths.push_back(test::random_labels(random, 2000));
      predictions.push_back(test::disturbed(random, truths.back()));
      metric.add(truths.back().class_id, predictions.back().class_id);
    }
    const SemanticScores scores = metric.scores();
    double sum = 0;
    double defined = 0;
    for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
      const auto expected = naive_iou(truths, predictions, benchmark_classes()[c].id);
      EXPECT_EQ(scores.classes[c].iou(), expected);
      sum += expected.value_or(0);
      defined += expected ? 1 : 0;
    }
    EXPECT_DOUBLE_EQ(scores.miou.value(), sum / defined);
  }
}

TEST(SemanticIou, HasNoMeanWithoutTruth) {
  SemanticIou metric;
  EXPECT_FALSE(metric.scores().miou.has_value());
  metric.add(std::vector<ClassId>(5, ClassId{40}), std::vector<ClassId>(5, ClassId{1}));
  EXPECT_FALSE(metric.scores().miou.has_value()) << "predictions where the truth is outside the 20 classes do not count";
}

}  // namespace
}  // namespace panoptic
