// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/labelled_vertices.h"

#include <utility>

#include "panoptic/eval/benchmark_classes.h"

namespace panoptic {

VertexLabels labels_of(const ScanTruth& truth) {
  return {truth.class_id, std::vector<std::uint32_t>(truth.instance.begin(), truth.instance.end())};
}

std::vector<InstanceMask> instance_masks(const LabelledVertices& prediction) {
  std::map<std::pair<ClassId, std::uint32_t>, InstanceMask> masks;
  const VertexLabels& labels = prediction.labels;
  for (std::size_t v = 0; v < labels.class_id.size(); ++v) {
    if (labels.instance[v] == 0 || !is_benchmark_thing(labels.class_id[v])) continue;
    masks[{labels.class_id[v], labels.instance[v]}].vertices.push_back(static_cast<std::uint32_t>(v));
  }
  std::vector<InstanceMask> list;
  for (auto& [key, mask] : masks) {
    const auto confidence = prediction.confidence.find(key.second);
    mask.class_id = key.first;
    mask.confidence = confidence == prediction.confidence.end() ? 1 : confidence->second;
    list.push_back(std::move(mask));
  }
  return list;
}

}  // namespace panoptic
