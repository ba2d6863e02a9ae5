// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Panoptic quality by COCO's rules, on any index space: pixels, or the vertices of scans.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "panoptic/eval/benchmark_classes.h"
#include "panoptic/eval/labelled_vertices.h"

namespace panoptic {

// Rules for how the vertices of a scan become segments, and which classes are averaged.
struct PqVariant {
  std::string name;
  std::size_t min_true_thing = 0;       // true things with less vertices become void
  std::size_t min_predicted_thing = 0;  // predicted things with less vertices become void
  bool merge_stuff = true;              // all of a stuff class is one segment, whatever its instance numbers
  bool average_true_only = false;       // leave classes without a true segment out of the averages
};

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

struct PqCounts {
  std::uint64_t tp = 0;
  std::uint64_t fp = 0;
  std::uint64_t fn = 0;
  double iou_sum = 0;  // over the matches
};

struct PqScores {
  std::optional<double> pq;  // nothing where there is nothing to count
  std::optional<double> sq;
  std::optional<double> rq;

  bool operator==(const PqScores&) const = default;
};
PqScores pq_scores(const PqCounts& counts);

struct PanopticScores {
  PqVariant variant;
  PqScores all;  // means over the classes that count
  PqScores things;
  PqScores stuff;
  std::array<PqCounts, kBenchmarkClassCount> counts;  // as in benchmark_classes()
};

class PanopticQuality {
 public:
  explicit PanopticQuality(std::size_t categories) : counts_(categories) {}

  // Adds one image or scene. Segments match if they are of one category and their IoU, void left out, is above one half. A
  // prediction that lies to more than half on void or on the crowd of its category is not counted. REQUIRES equal sizes and
  // categories below the number given.
  void add(const PqSegments& truth, const PqSegments& prediction);

  std::span<const PqCounts> counts() const { return counts_; }

 private:
  std::vector<PqCounts> counts_;
};

// The 20 classes of the benchmark as categories; everything else is void.
PqSegments true_segments(const VertexLabels& truth, const PqVariant& variant);
PqSegments predicted_segments(const VertexLabels& prediction, const PqVariant& variant);

// REQUIRES the counts of the 20 classes.
PanopticScores panoptic_scores(std::span<const PqCounts> counts, const PqVariant& variant);

}  // namespace panoptic
