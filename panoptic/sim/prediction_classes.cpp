// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/prediction_classes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace panoptic {
namespace {

struct Mistake {
  std::string_view truth;
  std::string_view given;
  float weight;
};

// Confusions by shape, use and place, as detectors on indoor images err. Reviewed by hand, not measured.
constexpr auto kMistakes = std::to_array<Mistake>({
    {"cabinet", "otherfurniture", 3},
    {"cabinet", "bookshelf", 2},
    {"cabinet", "counter", 2},
    {"cabinet", "desk", 1},
    {"cabinet", "refrigerator", 1},
    {"cabinet", "door", 1},
    {"bed", "sofa", 3},
    {"bed", "otherfurniture", 1},
    {"bed", "table", 0.5F},
    {"chair", "sofa", 2},
    {"chair", "otherfurniture", 2},
    {"chair", "table", 1},
    {"chair", "toilet", 0.3F},
    {"sofa", "chair", 3},
    {"sofa", "bed", 2},
    {"sofa", "otherfurniture", 1},
    {"table", "desk", 4},
    {"table", "otherfurniture", 2},
    {"table", "counter", 1},
    {"table", "cabinet", 1},
    {"table", "chair", 1},
    {"door", "cabinet", 2},
    {"door", "window", 1},
    {"door", "curtain", 1},
    {"door", "refrigerator", 0.5F},
    {"window", "curtain", 2},
    {"window", "picture", 2},
    {"window", "door", 1},
    {"bookshelf", "cabinet", 4},
    {"bookshelf", "otherfurniture", 1},
    {"picture", "window", 2},
    {"picture", "otherfurniture", 1},
    {"counter", "cabinet", 3},
    {"counter", "table", 2},
    {"counter", "desk", 2},
    {"desk", "table", 5},
    {"desk", "cabinet", 1},
    {"desk", "counter", 1},
    {"desk", "otherfurniture", 1},
    {"curtain", "window", 2},
    {"curtain", "shower curtain", 1},
    {"curtain", "door", 1},
    {"refrigerator", "cabinet", 3},
    {"refrigerator", "door", 2},
    {"refrigerator", "otherfurniture", 1},
    {"shower curtain", "curtain", 4},
    {"shower curtain", "door", 1},
    {"toilet", "chair", 1},
    {"toilet", "sink", 1},
    {"toilet", "otherfurniture", 1},
    {"sink", "toilet", 1},
    {"sink", "bathtub", 1},
    {"sink", "counter", 1},
    {"bathtub", "sink", 2},
    {"bathtub", "sofa", 0.5F},
    {"bathtub", "otherfurniture", 1},
    {"otherfurniture", "cabinet", 3},
    {"otherfurniture", "table", 1},
    {"otherfurniture", "chair", 1},
    {"otherfurniture", "bookshelf", 1},
    {"otherfurniture", "desk", 1},
    {"cat", "dog", 1},
    {"dog", "cat", 1},
});

constexpr auto kHallucinations = std::to_array<std::string_view>(
    {"picture", "cabinet", "otherfurniture", "otherfurniture", "chair", "door", "window", "curtain", "table", "bookshelf"});

// Gamma distributed with scale 1 (Marsaglia and Tsang 2000; for shapes below 1 through shape + 1).
double gamma(double shape, Random& random) {
  if (shape < 1) {
    const double above = gamma(shape + 1, random);
    return above * std::pow(1 - random.uniform(), 1 / shape);
  }
  const double d = shape - 1.0 / 3;
  const double c = 1 / std::sqrt(9 * d);
  for (;;) {
    const double x = random.normal();
    const double root = 1 + c * x;
    const double v = root * root * root;
    if (v > 0 && std::log(1 - random.uniform()) < 0.5 * x * x + d - d * v + d * std::log(v)) return d * v;
  }
}

}  // namespace

std::vector<ClassProbability> mistaken_for(ClassId class_id, const LabelSet& labels) {
  std::vector<ClassProbability> result;
  float sum = 0;
  for (const Mistake& m : kMistakes) {
    if (m.truth != labels.name_of(class_id)) continue;
    const LabelClass* given = labels.find(m.given);
    if (given == nullptr || !given->is_thing) continue;
    result.push_back({given->id, m.weight});
    sum += m.weight;
  }
  for (ClassProbability& p : result) p.probability /= sum;
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.class_id < b.class_id; });
  return result;
}

ClassId pick_mistake(ClassId class_id, double chance, const LabelSet& labels) {
  ClassId picked = class_id;
  double below = 0;
  for (const ClassProbability& p : mistaken_for(class_id, labels)) {
    if (chance < below) break;
    picked = p.class_id;
    below += static_cast<double>(p.probability);
  }
  return picked;
}

ClassId pick_hallucination(double chance, const LabelSet& labels) {
  const auto index = static_cast<std::size_t>(chance * static_cast<double>(kHallucinations.size()));
  const LabelClass* found = labels.find(kHallucinations[index]);
  return found != nullptr && found->is_thing ? found->id : ClassId::kUnknown;
}

float draw_score(bool correct, const PredictionNoise& noise, Random& random) {
  if (noise.score_mean >= 1) return 1;
  const double mean = static_cast<double>(noise.score_mean);
  const double certainty = static_cast<double>(noise.score_certainty);
  const double a = gamma(mean * certainty + (correct ? 1 : 0), random);
  const double b = gamma((1 - mean) * certainty + (correct ? 0 : 1), random);
  return static_cast<float>(std::clamp(a / (a + b), 0.001, 0.999));
}

Segment to_segment(ClassId truth, ClassId given, float score, const LabelSet& labels) {
  Segment segment{given, score, {}};
  const float certain = 0.5F + 0.5F * score;
  std::vector<ClassProbability> others;  // what else it might be: the truth, and what that is taken for
  if (certain < 1) others = mistaken_for(truth, labels);
  if (certain < 1) others.push_back({truth, 1});
  std::erase_if(others, [&](const ClassProbability& p) { return p.class_id == given; });
  float sum = 0;
  for (const ClassProbability& p : others) sum += p.probability;
  for (ClassProbability& p : others) p.probability *= (1 - certain) / sum;
  others.push_back({given, others.empty() ? 1.0F : certain});
  std::sort(others.begin(), others.end(), [](const auto& a, const auto& b) { return a.class_id < b.class_id; });
  segment.class_probabilities = std::move(others);
  return segment;
}

}  // namespace panoptic
