// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/evaluation.h"

#include <fmt/format.h>

#include <utility>

#include "panoptic/error.h"
#include "panoptic/eval/evaluation_counts.h"
#include "panoptic/eval/labelled_vertices.h"
#include "panoptic/eval/vertex_labels.h"

namespace panoptic {
namespace {

void require_same(const std::string& scene, std::size_t predicted, std::size_t vertices) {
  if (predicted == vertices) return;
  throw Error(fmt::format(
      "{}: labels for {} vertices, but the ground truth has {}; the prediction must have one per vertex, in their order", scene,
      predicted, vertices));
}

void count_coverage(const VertexLabels& truth, const std::vector<ClassId>& prediction, const std::vector<std::uint8_t>& reached,
                    Coverage& coverage) {
  coverage.vertices += truth.class_id.size();
  for (std::size_t v = 0; v < truth.class_id.size(); ++v) {
    if (truth.class_id[v] == ClassId::kUnknown) continue;
    ++coverage.annotated;
    coverage.reached += reached.empty() || reached[v] != 0 ? 1 : 0;
    coverage.labelled += prediction[v] != ClassId::kUnknown ? 1 : 0;
  }
}

Surface surface_of(const ScanTruth& truth) { return {truth.positions, truth.triangles}; }

Surface surface_of(const Mesh& mesh) {
  Surface surface{{}, mesh.triangles};
  surface.positions.reserve(mesh.vertices.size());
  for (const MeshVertex& vertex : mesh.vertices) surface.positions.push_back(vertex.position);
  return surface;
}

}  // namespace

std::optional<double> Coverage::coverage() const {
  if (annotated == 0) return std::nullopt;
  return static_cast<double>(labelled) / static_cast<double>(annotated);
}

Evaluation::Evaluation(const std::string& variant) : counts_(new Counts{{pq_variant(variant)}}) {
  for (const PqVariant& other : pq_variants()) {
    if (other.name != variant) counts_->variants.push_back(other);
  }
}
Evaluation::~Evaluation() = default;
Evaluation::Evaluation(Evaluation&&) noexcept = default;
Evaluation& Evaluation::operator=(Evaluation&&) noexcept = default;

void Evaluation::add(const LabelledVertices& prediction, const ScanTruth& truth) {
  const VertexLabels labels = labels_of(truth);
  require_same(truth.scene, prediction.labels.class_id.size(), labels.class_id.size());
  require_same(truth.scene, prediction.labels.instance.size(), labels.class_id.size());
  count_coverage(labels, prediction.labels.class_id, prediction.reached, counts_->coverage);
  started(counts_->semantic).add(labels.class_id, prediction.labels.class_id);
  counts_->add_panoptic(labels, prediction.labels);
  started(counts_->instances).add(labels, instance_masks(prediction));
  counts_->scenes.push_back(truth.scene);
}

LabelledVertices Evaluation::add(const LabelledMap& map, const ScanTruth& truth) {
  LabelledVertices prediction = carry_labels(map, truth.positions);
  add(prediction, truth);
  started(counts_->surface).add(surface_of(map.mesh), surface_of(truth));
  return prediction;
}

void Evaluation::add_semantic(const std::string& scene, const VertexLabels& truth, const std::vector<ClassId>& prediction) {
  require_same(scene, prediction.size(), truth.class_id.size());
  count_coverage(truth, prediction, {}, counts_->coverage);
  started(counts_->semantic).add(truth.class_id, prediction);
  counts_->scenes.push_back(scene);
}

void Evaluation::add_instances(const std::string& scene, const VertexLabels& truth, const std::vector<InstanceMask>& prediction) {
  std::vector<ClassId> covered(truth.class_id.size());
  for (const InstanceMask& mask : prediction) {
    for (const std::uint32_t v : mask.vertices) {
      if (v >= covered.size()) require_same(scene, v + std::size_t{1}, covered.size());
      covered[v] = mask.class_id;
    }
  }
  count_coverage(truth, covered, {}, counts_->coverage);
  started(counts_->instances).add(truth, prediction);
  counts_->scenes.push_back(scene);
}

void Evaluation::add_panoptic(const std::string& scene, const VertexLabels& truth, const VertexLabels& prediction) {
  require_same(scene, prediction.class_id.size(), truth.class_id.size());
  count_coverage(truth, prediction.class_id, {}, counts_->coverage);
  counts_->add_panoptic(truth, prediction);
  counts_->scenes.push_back(scene);
}

Scores Evaluation::scores() const {
  Scores scores;
  scores.scenes = counts_->scenes;
  scores.coverage = counts_->coverage;
  if (counts_->semantic) scores.semantic = counts_->semantic->scores();
  if (counts_->instances) scores.instance = counts_->instances->scores();
  for (std::size_t i = 0; i < counts_->panoptic.size(); ++i) {
    scores.panoptic.push_back(panoptic_scores(counts_->panoptic[i].counts(), counts_->variants[i]));
  }
  if (counts_->surface) scores.surface = counts_->surface->scores();
  return scores;
}

}  // namespace panoptic
