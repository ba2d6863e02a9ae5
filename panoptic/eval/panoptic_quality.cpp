// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/panoptic_quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/eval/benchmark_classes.h"

namespace panoptic {
namespace {

constexpr std::size_t kSmallest = 100;
constexpr double kHalf = 0.5;

struct Overlap {
  std::uint32_t truth = 0;  // as in segment_at
  std::uint32_t prediction = 0;
  std::size_t vertices = 0;
};

// Every pair of labels that occurs, void included, ascending.
std::vector<Overlap> overlaps_of(const PqSegments& truth, const PqSegments& prediction) {
  constexpr unsigned kHalfBits = 32;
  std::vector<std::uint64_t> pairs(truth.segment_at.size());
  for (std::size_t v = 0; v < pairs.size(); ++v) {
    pairs[v] = std::uint64_t{truth.segment_at[v]} << kHalfBits | prediction.segment_at[v];
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<Overlap> overlaps;
  for (std::size_t begin = 0; begin < pairs.size();) {
    std::size_t end = begin;
    while (end < pairs.size() && pairs[end] == pairs[begin]) ++end;
    overlaps.push_back(
        {static_cast<std::uint32_t>(pairs[begin] >> kHalfBits), static_cast<std::uint32_t>(pairs[begin]), end - begin});
    begin = end;
  }
  return overlaps;
}

// The areas of one pair of segmentations, by label (index + 1).
struct Areas {
  Areas(const PqSegments& truth, const PqSegments& prediction, std::span<const Overlap> overlaps)
      : of_truth(truth.segments.size() + 1),
        of_prediction(prediction.segments.size() + 1),
        forgiven(prediction.segments.size() + 1) {
    for (const Overlap& o : overlaps) {
      of_truth[o.truth] += o.vertices;
      of_prediction[o.prediction] += o.vertices;
      if (o.truth == 0) forgiven[o.prediction] += o.vertices;
    }
  }

  std::vector<std::size_t> of_truth;
  std::vector<std::size_t> of_prediction;
  std::vector<std::size_t> forgiven;  // of a prediction: on void
};

// Per vertex the number of its segment: all that share class and instance; and how large it is.
PqSegments segments_of(const VertexLabels& labels, const PqVariant& variant, std::size_t min_thing) {
  std::map<std::pair<std::size_t, std::uint32_t>, std::pair<std::size_t, std::uint32_t>> segments;  // -> size, label
  std::vector<std::pair<std::size_t, std::uint32_t>*> segment_at(labels.class_id.size(), nullptr);
  for (std::size_t v = 0; v < labels.class_id.size(); ++v) {
    const std::optional<std::size_t> category = benchmark_index(labels.class_id[v]);
    if (!category) continue;
    const bool merged = variant.merge_stuff && !benchmark_classes()[*category].is_thing;
    segment_at[v] = &segments[{*category, merged ? 0 : labels.instance[v]}];
    ++segment_at[v]->first;
  }
  PqSegments result;
  for (auto& [key, segment] : segments) {
    if (benchmark_classes()[key.first].is_thing && segment.first < min_thing) continue;
    result.segments.push_back({key.first, false});
    segment.second = static_cast<std::uint32_t>(result.segments.size());
  }
  result.segment_at.resize(segment_at.size());
  for (std::size_t v = 0; v < segment_at.size(); ++v) result.segment_at[v] = segment_at[v] == nullptr ? 0 : segment_at[v]->second;
  return result;
}

PqScores mean(std::span<const PqScores> scores) {
  if (scores.empty()) return {};
  PqScores mean{0, 0, 0};
  for (const PqScores& s : scores) {
    *mean.pq += *s.pq;
    *mean.sq += *s.sq;
    *mean.rq += *s.rq;
  }
  for (std::optional<double>* value : {&mean.pq, &mean.sq, &mean.rq}) **value /= static_cast<double>(scores.size());
  return mean;
}

}  // namespace

const std::array<PqVariant, 4>& pq_variants() {
  static const std::array<PqVariant, 4> kVariants = {{{"pq-scannet20", kSmallest, kSmallest, true, false},
                                                      {"seed", 0, kSmallest, true, false},
                                                      {"ndt", 0, 0, true, true},
                                                      {"coco", 0, 0, false, false}}};
  return kVariants;
}

const PqVariant& pq_variant(const std::string& name) {
  std::string names;
  for (const PqVariant& variant : pq_variants()) {
    if (variant.name == name) return variant;
    names += (names.empty() ? "" : ", ") + variant.name;
  }
  throw Error(fmt::format("no variant of panoptic quality is called '{}'; there are {}", name, names));
}

PqScores pq_scores(const PqCounts& c) {
  if (c.tp + c.fp + c.fn == 0) return {};
  const auto tp = static_cast<double>(c.tp);
  const double denominator = tp + kHalf * static_cast<double>(c.fp) + kHalf * static_cast<double>(c.fn);
  return {c.iou_sum / denominator, c.tp == 0 ? 0 : c.iou_sum / tp, tp / denominator};
}

void PanopticQuality::add(const PqSegments& truth, const PqSegments& prediction) {
  PANOPTIC_ASSERT(truth.segment_at.size() == prediction.segment_at.size());
  const std::vector<Overlap> overlaps = overlaps_of(truth, prediction);
  Areas areas(truth, prediction, overlaps);
  std::vector<bool> truth_matched(areas.of_truth.size());
  std::vector<bool> prediction_matched(areas.of_prediction.size());
  for (const Overlap& o : overlaps) {
    if (o.truth == 0 || o.prediction == 0) continue;
    const PqSegment& segment = truth.segments[o.truth - 1];
    if (segment.is_crowd || segment.category != prediction.segments[o.prediction - 1].category) continue;
    const std::size_t all =
        areas.of_truth[o.truth] + areas.of_prediction[o.prediction] - o.vertices - areas.forgiven[o.prediction];
    const double iou = static_cast<double>(o.vertices) / static_cast<double>(all);
    if (iou <= kHalf) continue;
    truth_matched[o.truth] = prediction_matched[o.prediction] = true;
    ++counts_[segment.category].tp;
    counts_[segment.category].iou_sum += iou;
  }
  std::map<std::size_t, std::uint32_t> crowd_of;  // the last one of a category
  for (std::uint32_t i = 1; i < areas.of_truth.size(); ++i) {
    const PqSegment& segment = truth.segments[i - 1];
    if (segment.is_crowd) {
      crowd_of[segment.category] = i;
    } else if (!truth_matched[i]) {
      ++counts_[segment.category].fn;
    }
  }
  for (const Overlap& o : overlaps) {
    if (o.truth == 0 || o.prediction == 0) continue;
    const auto crowd = crowd_of.find(prediction.segments[o.prediction - 1].category);
    if (crowd != crowd_of.end() && crowd->second == o.truth) areas.forgiven[o.prediction] += o.vertices;
  }
  for (std::size_t i = 1; i < areas.of_prediction.size(); ++i) {
    if (prediction_matched[i]) continue;
    const double forgiven = static_cast<double>(areas.forgiven[i]) / static_cast<double>(areas.of_prediction[i]);
    if (forgiven <= kHalf) ++counts_[prediction.segments[i - 1].category].fp;
  }
}

PqSegments true_segments(const VertexLabels& truth, const PqVariant& variant) {
  return segments_of(truth, variant, variant.min_true_thing);
}

PqSegments predicted_segments(const VertexLabels& prediction, const PqVariant& variant) {
  return segments_of(prediction, variant, variant.min_predicted_thing);
}

PanopticScores panoptic_scores(std::span<const PqCounts> counts, const PqVariant& variant) {
  PANOPTIC_ASSERT(counts.size() == kBenchmarkClassCount);
  PanopticScores scores;
  scores.variant = variant;
  std::copy(counts.begin(), counts.end(), scores.counts.begin());
  std::vector<PqScores> things;
  std::vector<PqScores> stuff;
  for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
    const PqCounts& n = counts[c];
    if (n.tp + n.fn + (variant.average_true_only ? 0 : n.fp) == 0) continue;
    (benchmark_classes()[c].is_thing ? things : stuff).push_back(pq_scores(n));
  }
  scores.things = mean(things);
  scores.stuff = mean(stuff);
  things.insert(things.begin(), stuff.begin(), stuff.end());
  scores.all = mean(things);
  return scores;
}

}  // namespace panoptic
