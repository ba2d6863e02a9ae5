// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Random scenes that stress the rules of the metrics: small regions, void, overlapping masks, confused classes, equal scores.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "panoptic/eval/labelled_vertices.h"

namespace panoptic::test {

inline std::size_t below(std::mt19937_64& random, std::size_t count) { return static_cast<std::size_t>(random() % count); }

// Classes inside and outside the benchmark.
inline ClassId any_class(std::mt19937_64& random) {
  constexpr std::uint16_t kClasses[] = {0, 1, 2, 3, 5, 5, 5, 7, 7, 13, 39, 40};
  return ClassId{kClasses[below(random, std::size(kClasses))]};
}

// Runs of 20 to 400 vertices; class and instance come back, so a segment may be in pieces.
inline VertexLabels random_labels(std::mt19937_64& random, std::size_t vertices) {
  VertexLabels labels;
  while (labels.class_id.size() < vertices) {
    const std::size_t length = std::min(vertices - labels.class_id.size(), 20 + below(random, 380));
    labels.class_id.insert(labels.class_id.end(), length, any_class(random));
    labels.instance.insert(labels.instance.end(), length, static_cast<std::uint32_t>(below(random, 4)));
  }
  return labels;
}

// The same labels with segments renamed, cut, grown and lost.
inline VertexLabels disturbed(std::mt19937_64& random, VertexLabels labels) {
  const std::size_t vertices = labels.class_id.size();
  for (std::size_t v = 0; v < vertices; ++v) labels.instance[v] = labels.instance[v] * 7 % 31 + 3;
  for (int damage = 0; damage < 6; ++damage) {
    const std::size_t begin = below(random, vertices);
    const std::size_t end = std::min(vertices, begin + below(random, 250));
    const ClassId class_id = any_class(random);
    const auto instance = static_cast<std::uint32_t>(below(random, 12));
    for (std::size_t v = begin; v < end; ++v) labels.class_id[v] = class_id, labels.instance[v] = instance;
  }
  return labels;
}

// Masks near the truth's instances and some out of nowhere; they may overlap, and scores repeat.
inline std::vector<InstanceMask> random_masks(std::mt19937_64& random, const VertexLabels& truth) {
  const std::size_t vertices = truth.class_id.size();
  std::vector<InstanceMask> masks;
  for (std::size_t count = below(random, 14); masks.size() < count;) {
    InstanceMask mask;
    mask.confidence = static_cast<double>(below(random, 6)) / 5;
    const std::size_t seed = below(random, vertices);
    mask.class_id = below(random, 4) == 0 ? any_class(random) : truth.class_id[seed];
    const std::size_t keep_percent = 30 + below(random, 71);
    const std::size_t stray_percent = below(random, 4) * 5;
    for (std::size_t v = 0; v < vertices; ++v) {
      const bool inside = truth.class_id[v] == truth.class_id[seed] && truth.instance[v] == truth.instance[seed];
      if (below(random, 100) < (inside ? keep_percent : stray_percent)) mask.vertices.push_back(static_cast<std::uint32_t>(v));
    }
    masks.push_back(std::move(mask));
  }
  return masks;
}

}  // namespace panoptic::test
