// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/instance_ap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "panoptic/eval/benchmark_classes.h"
#include "tests/eval/random_scenes.h"

namespace panoptic {
namespace {

constexpr ClassId kWall{1};
constexpr ClassId kTable{7};
constexpr ClassId kChair{5};
constexpr std::size_t kChairIndex = 4;
constexpr std::size_t kTableIndex = 6;

// The rules once more, as plainly as they can be said: every number is counted from the vertices where it is needed.
struct NaiveScene {
  VertexLabels truth;
  std::vector<InstanceMask> masks;

  bool is_void(std::size_t v) const { return !is_benchmark_thing(truth.class_id[v]); }
  long id(std::size_t v) const { return number(truth.class_id[v]) * 1000L + static_cast<long>(truth.instance[v]); }
  std::set<long> ids() const {
    std::set<long> found;
    for (std::size_t v = 0; v < truth.class_id.size(); ++v) {
      if (!is_void(v)) found.insert(id(v));
    }
    return found;
  }
  double size(long instance) const {
    double n = 0;
    for (std::size_t v = 0; v < truth.class_id.size(); ++v) n += !is_void(v) && id(v) == instance ? 1 : 0;
    return n;
  }
  double shared(long instance, const InstanceMask& mask) const {
    double n = 0;
    for (const std::uint32_t v : mask.vertices) n += !is_void(v) && id(v) == instance ? 1 : 0;
    return n;
  }
  double on_void(const InstanceMask& mask) const {
    return static_cast<double>(
        std::count_if(mask.vertices.begin(), mask.vertices.end(), [&](std::uint32_t v) { return is_void(v); }));
  }
  double iou(long instance, const InstanceMask& mask) const {
    const double both = shared(instance, mask);
    return both / (size(instance) + static_cast<double>(mask.vertices.size()) - both);
  }
};

// The curve as 6.5 writes it, with the padded recalls.
double naive_curve(const std::vector<std::pair<double, bool>>& ranked, double missed) {
  std::set<double> scores;
  for (const auto& [score, is_true] : ranked) scores.insert(score);
  std::vector<double> p;
  std::vector<double> c = {0};
  for (const double s : scores) {
    double tp = 0;
    double fp = 0;
    double fn = missed;
    for (const auto& [score, is_true] : ranked) {
      tp += is_true && score >= s ? 1 : 0;
      fp += !is_true && score >= s ? 1 : 0;
      fn += is_true && score < s ? 1 : 0;
    }
    p.push_back(tp / (tp + fp));
    c.push_back(tp / (tp + fn));
  }
  p.push_back(1);
  c.push_back(0);
  c.push_back(0);
  c[0] = c[1];
  double ap = 0;
  for (std::size_t k = 0; k < p.size(); ++k) ap += p[k] * (c[k] - c[k + 2]) / 2;
  return ap;
}

// `class_id`: kUnknown = one class for everything.
std::optional<double> naive_ap(const std::vector<NaiveScene>& scenes, ClassId class_id, double t) {
  const bool agnostic = class_id == ClassId::kUnknown;
  std::vector<std::pair<double, bool>> ranked;
  double missed = 0;
  bool any_truth = false;
  bool any_mask = false;
  for (const NaiveScene& scene : scenes) {
    std::vector<const InstanceMask*> masks;
    for (const InstanceMask& mask : scene.masks) {
      if ((agnostic || mask.class_id == class_id) && mask.vertices.size() >= 100) masks.push_back(&mask);
    }
    std::vector<long> truths;
    for (const long id : scene.ids()) {
      if (agnostic || id / 1000 == number(class_id)) truths.push_back(id);
    }
    any_mask = any_mask || !masks.empty();
    std::set<const InstanceMask*> used;
    for (const long g : truths) {
      if (scene.size(g) < 100) continue;
      any_truth = true;
      double best = -1;
      for (const InstanceMask* p : masks) {
        if (used.contains(p) || !(scene.iou(g, *p) > t)) continue;
        if (best < 0) {
          best = p->confidence;
          used.insert(p);
        } else {
          ranked.emplace_back(std::min(best, p->confidence), false);
          best = std::max(best, p->confidence);
        }
      }
      if (best < 0) {
        ++missed;
      } else {
        ranked.emplace_back(best, true);
      }
    }
    for (const InstanceMask* p : masks) {
      if (std::any_of(truths.begin(), truths.end(), [&](long g) { return scene.iou(g, *p) > t; })) continue;
      double ignored = scene.on_void(*p);
      for (const long g : truths) ignored += scene.size(g) < 100 ? scene.shared(g, *p) : 0;
      if (ignored / static_cast<double>(p->vertices.size()) <= t) ranked.emplace_back(p->confidence, false);
    }
  }
  if (!any_truth) return std::nullopt;
  if (!any_mask || ranked.empty()) return 0;
  return naive_curve(ranked, missed);
}

ApScores naive_scores(const std::vector<NaiveScene>& scenes, ClassId class_id) {
  ApScores scores;
  scores.ap50 = naive_ap(scenes, class_id, 0.5);
  scores.ap25 = naive_ap(scenes, class_id, 0.25);
  if (!scores.ap50) return scores;
  double sum = 0;
  for (int i = 0; i < 9; ++i) sum += *naive_ap(scenes, class_id, 0.5 + i * ((0.5 + 0.05) - 0.5));
  scores.ap = sum / 9;
  return scores;
}

InstanceScores scores_of(const std::vector<NaiveScene>& scenes) {
  InstanceAp metric;
  for (const NaiveScene& scene : scenes) metric.add(scene.truth, scene.masks);
  return metric.scores();
}

// Runs of (class, instance, count).
struct Run {
  ClassId class_id;
  std::uint32_t instance;
  std::size_t count;
};
VertexLabels labels_from(const std::vector<Run>& runs) {
  VertexLabels labels;
  for (const Run& run : runs) {
    labels.class_id.insert(labels.class_id.end(), run.count, run.class_id);
    labels.instance.insert(labels.instance.end(), run.count, run.instance);
  }
  return labels;
}

InstanceMask mask_of(ClassId class_id, double confidence, std::uint32_t begin, std::uint32_t end) {
  InstanceMask mask{class_id, confidence, {}};
  for (std::uint32_t v = begin; v < end; ++v) mask.vertices.push_back(v);
  return mask;
}

TEST(InstanceAp, EqualsTheNaiveCountOnRandomScenes) {
  std::mt19937_64 random(3);
  std::size_t defined = 0;
  for (int round = 0; round < 24; ++round) {
    std::vector<NaiveScene> scenes;
    for (std::size_t s = 0; s <= test::below(random, 3); ++s) {
      const VertexLabels truth = test::random_labels(random, 1500);
      scenes.push_back({truth, test::random_masks(random, truth)});
    }
    const InstanceScores scores = scores_of(scenes);
    for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
      const BenchmarkClass& benchmark = benchmark_classes()[c];
      if (!benchmark.is_thing) continue;
      EXPECT_EQ(scores.classes[c], naive_scores(scenes, benchmark.id)) << "round " << round << " " << benchmark.name;
      defined += scores.classes[c].ap ? 1 : 0;
    }
    EXPECT_EQ(scores.class_agnostic, naive_scores(scenes, ClassId::kUnknown)) << "round " << round;
  }
  EXPECT_GT(defined, 40U);
}

TEST(InstanceAp, GivesNoScoreToAClassWithoutTruthWhateverIsPredicted) {
  const VertexLabels truth = labels_from({{kChair, 1, 200}, {kTable, 1, 99}, {ClassId{0}, 0, 300}});
  const InstanceScores scores = scores_of({{truth, {mask_of(kChair, 0.5, 0, 200), mask_of(kTable, 0.9, 0, 200)}}});
  EXPECT_EQ(scores.classes[kTableIndex], ApScores{}) << "its only instance is too small";
  EXPECT_EQ(scores.classes[kChairIndex], (ApScores{1, 1, 1}));
  EXPECT_EQ(scores.mean, (ApScores{1, 1, 1}));
}

TEST(InstanceAp, GivesNothingToAClassWithoutPredictions) {
  const VertexLabels truth = labels_from({{kChair, 1, 200}, {kTable, 1, 200}});
  const InstanceScores scores = scores_of({{truth, {mask_of(kChair, 0.5, 0, 200)}}});
  EXPECT_EQ(scores.classes[kTableIndex], (ApScores{0, 0, 0}));
  EXPECT_EQ(scores.mean, (ApScores{0.5, 0.5, 0.5}));
  EXPECT_EQ(scores_of({{truth, {}}}).mean, (ApScores{0, 0, 0})) << "an empty prediction";
}

TEST(InstanceAp, GivesZeroWhereEveryPredictionIsIgnored) {
  const VertexLabels truth = labels_from({{kChair, 1, 200}, {kWall, 0, 300}});
  EXPECT_EQ(scores_of({{truth, {mask_of(kChair, 0.5, 200, 500)}}}).mean, (ApScores{0, 0, 0}));
}

TEST(InstanceAp, HasNoScoreAtAllWithoutScenesOrThings) {
  EXPECT_EQ(scores_of({}).mean, ApScores{});
  EXPECT_EQ(scores_of({{labels_from({{kWall, 1, 300}}), {mask_of(kWall, 1, 0, 300)}}}).mean, ApScores{});
}

TEST(InstanceAp, CountsTheInstanceNumberZeroAsAnInstance) {
  const VertexLabels truth = labels_from({{kChair, 0, 200}, {kChair, 1, 200}});
  EXPECT_EQ(scores_of({{truth, {mask_of(kChair, 0.5, 0, 200), mask_of(kChair, 0.5, 200, 400)}}}).mean, (ApScores{1, 1, 1}));
}

TEST(InstanceAp, TakesThresholdsStrictly) {
  const VertexLabels truth = labels_from({{kChair, 1, 200}, {kTable, 1, 300}});
  const InstanceScores half = scores_of({{truth, {mask_of(kChair, 0.5, 100, 200)}}});
  EXPECT_EQ(half.classes[kChairIndex].ap50, 0) << "an IoU of exactly one half is no match";
  EXPECT_EQ(half.classes[kChairIndex].ap25, 1);
}

TEST(InstanceAp, TakesNoneOfTheNineThresholdsAsReachedByEquality) {
  const VertexLabels truth = labels_from({{kChair, 1, 1000}});
  for (std::uint32_t i = 0; i < 9; ++i) {
    const InstanceScores scores = scores_of({{truth, {mask_of(kChair, 0.5, 0, 500 + 50 * i)}}});
    EXPECT_DOUBLE_EQ(scores.classes[kChairIndex].ap.value(), i / 9.0) << i;
  }
}

}  // namespace
}  // namespace panoptic
