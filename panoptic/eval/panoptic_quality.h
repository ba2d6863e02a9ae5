// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Panoptic quality by COCO's rules, on any index space: pixels, or the vertices of scans.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "panoptic/base/json_value.h"
#include "panoptic/evaluation.h"

namespace panoptic {

// "pq-scannet20" (the default), "seed", "ndt", "coco": docs/evaluation.md.
const std::array<PqVariant, 4>& pq_variants();

// Throws Error listing the variants if there is none of that name.
const PqVariant& pq_variant(const std::string& name);

struct PqSegment {
  std::size_t category = 0;
  bool is_crowd = false;  // of the truth: an unseparated group, never matched
};

struct PqSegments {
  std::vector<std::uint32_t> segment_at;  // 1 + index into segments, 0 = void
  std::vector<PqSegment> segments;
};

PqScores pq_scores(const PqCounts& counts);

class PanopticQuality {
 public:
  explicit PanopticQuality(std::size_t categories) : counts_(categories) {}

  // Adds one image or scene. Segments match if they are of one category and their IoU, void left out, is above one half. A
  // prediction that lies to more than half on void or on the crowd of its category is not counted. REQUIRES equal sizes and
  // categories below the number given.
  void add(const PqSegments& truth, const PqSegments& prediction);

  std::span<const PqCounts> counts() const { return counts_; }

  // The counts for another process, and their addition. Throws Error unless they are sound (saved_counts.cpp).
  Json saved() const;
  void add_saved(const JsonValue& saved);

 private:
  std::vector<PqCounts> counts_;
};

// The 20 classes of the benchmark as categories; everything else is void.
PqSegments true_segments(const VertexLabels& truth, const PqVariant& variant);
PqSegments predicted_segments(const VertexLabels& prediction, const PqVariant& variant);

// REQUIRES the counts of the 20 classes.
PanopticScores panoptic_scores(std::span<const PqCounts> counts, const PqVariant& variant);

}  // namespace panoptic
