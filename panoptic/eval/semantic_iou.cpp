// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/semantic_iou.h"

#include "panoptic/error.h"
#include "panoptic/eval/benchmark_classes.h"

namespace panoptic {

std::optional<double> ClassIou::iou() const {
  const std::uint64_t all = tp + fp + fn;
  if (all == 0) return std::nullopt;
  return static_cast<double>(tp) / static_cast<double>(all);
}

void SemanticIou::add(std::span<const ClassId> truth, std::span<const ClassId> prediction) {
  PANOPTIC_ASSERT(truth.size() == prediction.size());
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const std::optional<std::size_t> row = benchmark_index(truth[v]);
    if (row) ++confusion_[*row][benchmark_index(prediction[v]).value_or(kBenchmarkClassCount)];
  }
}

SemanticScores SemanticIou::scores() const {
  SemanticScores scores;
  double sum = 0;
  std::size_t defined = 0;
  for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
    ClassIou& counts = scores.classes[c];
    counts.tp = confusion_[c][c];
    for (std::size_t other = 0; other < kColumns; ++other) {
      if (other == c) continue;
      counts.fn += confusion_[c][other];
      if (other < kBenchmarkClassCount) counts.fp += confusion_[other][c];
    }
    const std::optional<double> iou = counts.iou();
    if (!iou) continue;
    sum += *iou;
    ++defined;
  }
  if (defined > 0) scores.miou = sum / static_cast<double>(defined);
  return scores;
}

}  // namespace panoptic
