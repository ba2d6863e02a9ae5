// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The counts of an Evaluation.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "panoptic/eval/instance_ap.h"
#include "panoptic/eval/panoptic_quality.h"
#include "panoptic/eval/semantic_iou.h"
#include "panoptic/eval/surface_metrics.h"
#include "panoptic/evaluation.h"

namespace panoptic {

// The counts of what was added, made when there is something to count.
template <typename Counter>
Counter& started(std::optional<Counter>& counter) {
  return counter ? *counter : counter.emplace();
}

struct Evaluation::Counts {
  std::vector<PqVariant> variants;
  std::vector<std::string> scenes = {};
  Coverage coverage = {};
  std::optional<SemanticIou> semantic = {};
  std::optional<InstanceAp> instances = {};
  std::vector<PanopticQuality> panoptic = {};  // one per variant; empty until there is something to count
  std::optional<SurfaceMetrics> surface = {};

  void add_panoptic(const VertexLabels& truth, const VertexLabels& prediction) {
    if (panoptic.empty()) panoptic.assign(variants.size(), PanopticQuality(kBenchmarkClassCount));
    for (std::size_t i = 0; i < variants.size(); ++i) {
      panoptic[i].add(true_segments(truth, variants[i]), predicted_segments(prediction, variants[i]));
    }
  }
};

}  // namespace panoptic
