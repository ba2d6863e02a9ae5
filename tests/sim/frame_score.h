// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Panoptic quality of single frames, by COCO's rules written down naively, and how often scores are right.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "panoptic/segmentation.h"
#include "panoptic/sim/renderer.h"

namespace panoptic::test {

class FrameScore {
 public:
  explicit FrameScore(LabelSet labels) : labels_(std::move(labels)) {}

  void add(const Segmentation& s, const Rendering& truth) {
    std::map<Key, int> truth_area;
    std::map<int, int> area;
    std::map<std::pair<Key, int>, int> shared;
    for (std::size_t i = 0; i < truth.depth.size(); ++i) {
      const Key key{truth.class_id[i], truth.instance[i]};
      const int segment = s.segment_at[i];
      if (key.first != ClassId::kUnknown) ++truth_area[key];
      if (segment != 0) ++area[segment];
      if (segment != 0) ++shared[{key, segment}];
    }
    std::map<int, int> void_area;
    for (const auto& [pair, pixels] : shared) {
      if (pair.first.first == ClassId::kUnknown) void_area[pair.second] += pixels;
    }
    std::set<Key> found;
    std::set<int> right;
    for (const auto& [pair, pixels] : shared) {
      const auto& [key, segment] = pair;
      if (key.first == ClassId::kUnknown || s.segments[static_cast<std::size_t>(segment) - 1].class_id != key.first) continue;
      const double iou = static_cast<double>(pixels) / (truth_area[key] + area[segment] - pixels - void_area[segment]);
      if (iou <= 0.5) continue;
      counts_[key.first].iou += iou;
      ++counts_[key.first].hits;
      found.insert(key);
      right.insert(segment);
    }
    for (const auto& [key, pixels] : truth_area) counts_[key.first].misses += found.contains(key) ? 0 : 1;
    for (const auto& [segment, pixels] : area) {
      if (2 * void_area[segment] > pixels) continue;
      count(s.segments[static_cast<std::size_t>(segment) - 1], right.contains(segment));
    }
  }

  // In percent, the mean over classes.
  double pq() const {
    double sum = 0;
    for (const auto& [class_id, c] : counts_) sum += c.iou / (c.hits + 0.5 * c.misses + 0.5 * c.wrong);
    return 100 * sum / static_cast<double>(counts_.size());
  }

  // Things by their score in five bins: how many, and the share of correct ones.
  static constexpr std::size_t kBins = 5;
  struct Bin {
    int count = 0;
    int correct = 0;
    double score_sum = 0;
  };
  const std::array<Bin, kBins>& bins() const { return bins_; }
  double precision() const {
    Bin all;
    for (const Bin& bin : bins_) all = {all.count + bin.count, all.correct + bin.correct, 0};
    return static_cast<double>(all.correct) / all.count;
  }

 private:
  using Key = std::pair<ClassId, std::uint16_t>;
  struct Count {
    double iou = 0;
    int hits = 0;
    int misses = 0;
    int wrong = 0;
  };

  void count(const Segment& segment, bool correct) {
    if (!correct) ++counts_[segment.class_id].wrong;
    if (!labels_.is_thing(segment.class_id)) return;
    Bin& bin = bins_[std::min(static_cast<std::size_t>(segment.score * kBins), kBins - 1)];
    ++bin.count;
    bin.correct += correct ? 1 : 0;
    bin.score_sum += static_cast<double>(segment.score);
  }

  LabelSet labels_;
  std::map<ClassId, Count> counts_;
  std::array<Bin, kBins> bins_{};
};

}  // namespace panoptic::test
