// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/instance_ap.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/eval/average_precision.h"
#include "panoptic/eval/benchmark_classes.h"

namespace panoptic {
namespace {

using Scene = InstanceAp::Scene;

constexpr std::size_t kThresholds = 9;
constexpr double kFirstThreshold = 0.5;
constexpr double kThresholdStep =
    (kFirstThreshold + 0.05) - kFirstThreshold;  // as the evaluator gets it: a little more than 0.05
constexpr double kLooseThreshold = 0.25;
constexpr std::size_t kVoid = SIZE_MAX;

// Per vertex the index of its true instance, or kVoid. The instances are appended to the scene.
std::vector<std::size_t> true_instances(const VertexLabels& truth, Scene& scene) {
  std::map<std::pair<ClassId, std::uint32_t>, std::size_t> index_of;
  for (std::size_t v = 0; v < truth.class_id.size(); ++v) {
    if (is_benchmark_thing(truth.class_id[v])) index_of[{truth.class_id[v], truth.instance[v]}] = 0;
  }
  for (auto& [key, index] : index_of) {
    index = scene.truths.size();
    scene.truths.push_back({*benchmark_index(key.first), 0, {}});
  }
  std::vector<std::size_t> truth_at(truth.class_id.size(), kVoid);
  for (std::size_t v = 0; v < truth_at.size(); ++v) {
    if (!is_benchmark_thing(truth.class_id[v])) continue;
    truth_at[v] = index_of.find({truth.class_id[v], truth.instance[v]})->second;
    ++scene.truths[truth_at[v]].vertices;
  }
  return truth_at;
}

void add_prediction(const InstanceMask& mask, std::size_t category, const std::vector<std::size_t>& truth_at, Scene& scene) {
  InstanceAp::Prediction prediction{category, mask.vertices.size(), 0, mask.confidence, {}};
  std::map<std::size_t, std::size_t> shared;
  for (const std::uint32_t v : mask.vertices) {
    PANOPTIC_ASSERT(v < truth_at.size());
    if (truth_at[v] == kVoid) {
      ++prediction.on_void;
    } else {
      ++shared[truth_at[v]];
    }
  }
  for (const auto& [truth, vertices] : shared) {
    if (scene.truths[truth].category != category) continue;
    scene.truths[truth].predictions.push_back({scene.predictions.size(), vertices});
    prediction.truths.push_back({truth, vertices});
  }
  scene.predictions.push_back(std::move(prediction));
}

double iou_of(const InstanceAp::TrueInstance& truth, const InstanceAp::Prediction& prediction, std::size_t shared) {
  return static_cast<double>(shared) / static_cast<double>(truth.vertices + prediction.vertices - shared);
}

// Steps 1 and 2 of the count: every large true instance takes its first prediction above the threshold.
void match_truths(const Scene& scene, std::size_t category, double threshold, RankedMatches& matches) {
  std::vector<bool> used(scene.predictions.size(), false);
  for (const InstanceAp::TrueInstance& truth : scene.truths) {
    if (truth.category != category || truth.vertices < kMinRegionVertices) continue;
    matches.has_truth = true;
    std::optional<double> score;
    for (const auto& [index, shared] : truth.predictions) {
      const InstanceAp::Prediction& prediction = scene.predictions[index];
      if (used[index] || !(iou_of(truth, prediction, shared) > threshold)) continue;
      if (!score) {
        score = prediction.confidence;
        used[index] = true;
      } else {  // a second prediction of the same thing: the weaker one is false
        matches.falses.push_back(std::min(*score, prediction.confidence));
        score = std::max(*score, prediction.confidence);
      }
    }
    if (score) {
      matches.trues.push_back(*score);
    } else {
      ++matches.missed;
    }
  }
}

// Step 3: predictions that fit nothing are false, unless they lie mostly where nothing can be said.
void add_false_predictions(const Scene& scene, std::size_t category, double threshold, RankedMatches& matches) {
  for (const InstanceAp::Prediction& prediction : scene.predictions) {
    if (prediction.category != category) continue;
    matches.has_prediction = true;
    bool fits = false;
    std::size_t ignored = prediction.on_void;
    for (const auto& [index, shared] : prediction.truths) {
      const InstanceAp::TrueInstance& truth = scene.truths[index];
      fits = fits || iou_of(truth, prediction, shared) > threshold;
      if (truth.vertices < kMinRegionVertices) ignored += shared;
    }
    const double proportion = static_cast<double>(ignored) / static_cast<double>(prediction.vertices);
    if (!fits && proportion <= threshold) matches.falses.push_back(prediction.confidence);
  }
}

std::optional<double> ap_at(std::span<const Scene> scenes, std::size_t category, double threshold) {
  RankedMatches matches;
  for (const Scene& scene : scenes) {
    match_truths(scene, category, threshold, matches);
    add_false_predictions(scene, category, threshold, matches);
  }
  return average_precision(matches);
}

ApScores ap_of(std::span<const Scene> scenes, std::size_t category) {
  ApScores scores;
  scores.ap25 = ap_at(scenes, category, kLooseThreshold);
  scores.ap50 = ap_at(scenes, category, kFirstThreshold);
  if (!scores.ap50) return scores;  // undefined at one threshold, undefined at all
  double sum = 0;
  for (std::size_t i = 0; i < kThresholds; ++i) {
    sum += ap_at(scenes, category, kFirstThreshold + static_cast<double>(i) * kThresholdStep).value_or(0);
  }
  scores.ap = sum / static_cast<double>(kThresholds);
  return scores;
}

// The mean of one of the three scores over the classes that have it.
std::optional<double> mean(std::span<const ApScores> classes, std::optional<double> ApScores::*score) {
  double sum = 0;
  std::size_t defined = 0;
  for (const ApScores& c : classes) {
    if (!(c.*score)) continue;
    sum += *(c.*score);
    ++defined;
  }
  if (defined == 0) return std::nullopt;
  return sum / static_cast<double>(defined);
}

}  // namespace

void InstanceAp::add(const VertexLabels& truth, const std::vector<InstanceMask>& predictions) {
  PANOPTIC_ASSERT(truth.class_id.size() == truth.instance.size());
  Scene by_class;
  const std::vector<std::size_t> truth_at = true_instances(truth, by_class);
  Scene agnostic = by_class;
  for (TrueInstance& instance : agnostic.truths) instance.category = 0;
  for (const InstanceMask& mask : predictions) {
    if (mask.vertices.size() < kMinRegionVertices) continue;
    if (is_benchmark_thing(mask.class_id)) add_prediction(mask, *benchmark_index(mask.class_id), truth_at, by_class);
    add_prediction(mask, 0, truth_at, agnostic);
  }
  by_class_.push_back(std::move(by_class));
  agnostic_.push_back(std::move(agnostic));
}

InstanceScores InstanceAp::scores() const {
  InstanceScores scores;
  for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
    if (benchmark_classes()[c].is_thing) scores.classes[c] = ap_of(by_class_, c);
  }
  for (const auto score : {&ApScores::ap, &ApScores::ap50, &ApScores::ap25}) scores.mean.*score = mean(scores.classes, score);
  scores.class_agnostic = ap_of(agnostic_, 0);
  return scores;
}

}  // namespace panoptic
