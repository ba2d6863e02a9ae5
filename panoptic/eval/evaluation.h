// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// All metrics of a map or a method over one or many scans. Scenes accumulate as the benchmarks do: counts are summed over the
// scenes and scores taken at the end, never a mean of scores.
//
//   Evaluation evaluation;
//   for (...) evaluation.add(map, truth);       // or add(prediction, truth), if the labels are on the truth's vertices already
//   const Scores scores = evaluation.scores();  // scores.panoptic.front().all.pq ...
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/data/scan_truth.h"
#include "panoptic/eval/instance_ap.h"
#include "panoptic/eval/labelled_vertices.h"
#include "panoptic/eval/panoptic_quality.h"
#include "panoptic/eval/semantic_iou.h"
#include "panoptic/eval/surface_metrics.h"
#include "panoptic/eval/vertex_labels.h"

namespace panoptic {

// The part of the truth that the prediction reaches and labels.
struct Coverage {
  std::uint64_t vertices = 0;
  std::uint64_t annotated = 0;  // true class known
  std::uint64_t reached = 0;    // of those, near a surface of the map
  std::uint64_t labelled = 0;   // of those, given a class

  std::optional<double> coverage() const;  // labelled / annotated
};

// A part that was not evaluated is absent (panoptic: empty).
struct Scores {
  std::vector<std::string> scenes;
  Coverage coverage;
  std::optional<SemanticScores> semantic;
  std::optional<InstanceScores> instance;
  std::vector<PanopticScores> panoptic;  // the variant asked for, then the others
  std::optional<SurfaceScores> surface;
};

// Not thread-safe.
class Evaluation {
 public:
  // Throws Error for an unknown variant.
  explicit Evaluation(const std::string& variant = "pq-scannet20");

  // A prediction for the vertices of the truth: semantic, instance and panoptic scores. Throws Error naming the scene if the
  // numbers of vertices differ.
  void add(const LabelledVertices& prediction, const ScanTruth& truth);

  // Carries the map's labels to the vertices of the truth (vertex_labels.h), adds them, and compares the surfaces too.
  // Returns the labels, for a submission.
  LabelledVertices add(const LabelledMap& map, const ScanTruth& truth);

  // One part alone, for predictions that have no more. `scene` is for messages; sizes are checked as above.
  void add_semantic(const std::string& scene, const VertexLabels& truth, const std::vector<ClassId>& prediction);
  void add_instances(const std::string& scene, const VertexLabels& truth, const std::vector<InstanceMask>& prediction);
  void add_panoptic(const std::string& scene, const VertexLabels& truth, const VertexLabels& prediction);

  Scores scores() const;

 private:
  void count_semantic(const VertexLabels& truth, const std::vector<ClassId>& prediction);
  void count_panoptic(const VertexLabels& truth, const VertexLabels& prediction);

  std::vector<std::string> scenes_;
  Coverage coverage_;
  std::optional<SemanticIou> semantic_;
  std::optional<InstanceAp> instances_;
  std::vector<PqVariant> variants_;
  std::vector<PanopticQuality> panoptic_;  // one per variant; empty until there is something to count
  std::optional<SurfaceMetrics> surface_;
};

}  // namespace panoptic
