// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <utility>

#include "panoptic/predict/decoders.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

constexpr auto kA = static_cast<ClassId>(4);
constexpr auto kB = static_cast<ClassId>(9);
const std::vector<ClassId> kClassOf = {kB, ClassId::kUnknown, kA, kB, ClassId::kUnknown, kA};

Model model_with(std::size_t classes) {
  Model model;
  model.path = "tiny.toml";
  model.task = "semantic";
  model.decoder = "semantic_logits";
  model.classes.resize(classes);
  model.input.width = 7;
  model.input.height = 5;
  return model;
}

ClassScores decode_semantic_logits(std::vector<Tensor> outputs, const DecodeContext& context) {
  const Reading reading = recognise(outputs, context.model, "semantic");
  return *decode(std::move(outputs), reading, context).scores;
}

Tensor random_logits(int classes, int height, int width, float spread) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal(0, spread);
  Tensor tensor{{1, classes, height, width}, {}};
  tensor.values.resize(static_cast<std::size_t>(classes) * static_cast<std::size_t>(height) * static_cast<std::size_t>(width));
  for (float& value : tensor.values) value = normal(random);
  return tensor;
}

// Probability of each class of the label set in one cell, as the words say it.
std::map<ClassId, double> naive_probabilities(const Tensor& logits, int x, int y) {
  const auto at = [&](std::size_t c) {
    const auto height = static_cast<std::size_t>(logits.shape[2]);
    const auto width = static_cast<std::size_t>(logits.shape[3]);
    return static_cast<double>(logits.values[(c * height + static_cast<std::size_t>(y)) * width + static_cast<std::size_t>(x)]);
  };
  double sum = 0;
  for (std::size_t c = 0; c < kClassOf.size(); ++c) sum += std::exp(at(c));
  std::map<ClassId, double> probabilities;
  for (std::size_t c = 0; c < kClassOf.size(); ++c) probabilities[kClassOf[c]] += std::exp(at(c)) / sum;
  return probabilities;
}

// Bilinear between the cells around a pixel; beyond the outermost centres their value holds.
std::map<ClassId, double> naive_at_pixel(const Tensor& logits, double x, double y) {
  x = std::min(std::max(x, 0.0), logits.shape[3] - 1.0);
  y = std::min(std::max(y, 0.0), logits.shape[2] - 1.0);
  std::map<ClassId, double> mixed;
  for (int cell_y = 0; cell_y < logits.shape[2]; ++cell_y) {
    for (int cell_x = 0; cell_x < logits.shape[3]; ++cell_x) {
      const double share = std::max(0.0, 1 - std::abs(x - cell_x)) * std::max(0.0, 1 - std::abs(y - cell_y));
      for (const auto& [id, p] : naive_probabilities(logits, cell_x, cell_y)) mixed[id] += share * p;
    }
  }
  return mixed;
}

TEST(SemanticLogits, AddsProbabilitiesOfClassesWithTheSameCounterpart) {
  const Model model = model_with(kClassOf.size());
  const Tensor logits = random_logits(6, 5, 7, 3);
  const ClassScores scores = decode_semantic_logits({logits}, {model, kClassOf, {7, 5, 7, 5, 1, 1}});
  ASSERT_EQ(scores.classes.size(), 3U);
  EXPECT_EQ(scores.classes[0], ClassId::kUnknown);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) {
      const auto expected = naive_probabilities(logits, x, y);
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(scores.values[static_cast<std::size_t>(y * 7 + x) * 3 + k], expected.at(scores.classes[k]), 1e-5);
      }
    }
  }
}

struct Layout {
  int image_width, image_height, input_width, input_height;
  double scale_x, scale_y;
};

class SemanticLayout : public testing::TestWithParam<Layout> {};

// Stretched up, stretched down, letterboxed with the lower part of the input unused.
INSTANTIATE_TEST_SUITE_P(SemanticLogits, SemanticLayout,
                         testing::Values(Layout{40, 30, 56, 40, 1.4, 40.0 / 30}, Layout{5, 4, 56, 40, 11.2, 10},
                                         Layout{56, 20, 56, 40, 1, 1}));

TEST_P(SemanticLayout, EqualsInterpolatedProbabilitiesAtEveryPixel) {
  const Layout& l = GetParam();
  const Placement placement{l.image_width, l.image_height, l.input_width, l.input_height, l.scale_x, l.scale_y};
  const Model model = model_with(kClassOf.size());
  const Tensor logits = random_logits(6, 5, 7, 1);
  const ClassScores scores = decode_semantic_logits({logits}, {model, kClassOf, placement});
  const Image<ClassId> image = most_likely(scores, l.image_width, l.image_height);
  ASSERT_TRUE(image.same_size(l.image_width, l.image_height));
  for (int v = 0; v < l.image_height; ++v) {
    for (int u = 0; u < l.image_width; ++u) {
      const double x = ((u + 0.5) * l.scale_x / l.input_width) * 7 - 0.5;
      const double y = ((v + 0.5) * l.scale_y / l.input_height) * 5 - 0.5;
      auto expected = naive_at_pixel(logits, x, y);
      double best = 0;
      for (const auto& [id, p] : expected) best = std::max(best, p);
      EXPECT_NEAR(expected[image(u, v)], best, 1e-5) << u << " " << v;
    }
  }
}

// The network's likeliest class at a place between its cells: what it is in the label set, and by how much it leads.
std::pair<ClassId, double> naive_likeliest_first(const Tensor& logits, double x, double y) {
  const int width = logits.shape[3];
  const int height = logits.shape[2];
  x = std::clamp(x, 0.0, width - 1.0);
  y = std::clamp(y, 0.0, height - 1.0);
  std::vector<double> mixed(kClassOf.size(), 0.0);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const auto logit = [&](std::size_t c) {
        return double{
            logits.values[(c * static_cast<std::size_t>(height) + static_cast<std::size_t>(v)) * static_cast<std::size_t>(width) +
                          static_cast<std::size_t>(u)]};
      };
      double sum = 0;
      for (std::size_t c = 0; c < mixed.size(); ++c) sum += std::exp(logit(c));
      const double share = std::max(0.0, 1 - std::abs(x - u)) * std::max(0.0, 1 - std::abs(y - v));
      for (std::size_t c = 0; c < mixed.size(); ++c) mixed[c] += share * std::exp(logit(c)) / sum;
    }
  }
  const auto best = std::max_element(mixed.begin(), mixed.end());
  const ClassId class_id = kClassOf[static_cast<std::size_t>(best - mixed.begin())];
  const double most = *best;
  *best = 0;
  return {class_id, most - *std::max_element(mixed.begin(), mixed.end())};
}

TEST_P(SemanticLayout, LikeliestFirstIsTheLikeliestOfTheNetworksOwnClassesAtEveryPixel) {
  const Layout& l = GetParam();
  const Placement placement{l.image_width, l.image_height, l.input_width, l.input_height, l.scale_x, l.scale_y};
  const Model model = model_with(kClassOf.size());
  const Tensor logits = random_logits(6, 5, 7, 1);
  const ClassScores scores = decode_semantic_logits({logits}, {model, kClassOf, placement, true});
  const Image<ClassId> image = most_likely(average({scores}, 1), l.image_width, l.image_height);
  ASSERT_TRUE(image.same_size(l.image_width, l.image_height));
  int clear = 0;
  for (int v = 0; v < l.image_height; ++v) {
    for (int u = 0; u < l.image_width; ++u) {
      const double x = ((u + 0.5) * l.scale_x / l.input_width) * 7 - 0.5;
      const double y = ((v + 0.5) * l.scale_y / l.input_height) * 5 - 0.5;
      const auto [expected, lead] = naive_likeliest_first(logits, x, y);
      if (lead <= 1e-5) continue;
      EXPECT_EQ(image(u, v), expected) << u << " " << v;
      ++clear;
    }
  }
  EXPECT_GT(clear, l.image_width * l.image_height * 9 / 10);
}

// Logits of one row of cells, from the probabilities of the network's classes in each.
Tensor logits_of(const std::vector<std::vector<double>>& cells) {
  const std::size_t classes = cells[0].size();
  Tensor logits{{1, static_cast<int>(classes), 1, static_cast<int>(cells.size())}, {}};
  for (std::size_t c = 0; c < classes; ++c) {
    for (const std::vector<double>& cell : cells) logits.values.push_back(static_cast<float>(std::log(cell[c])));
  }
  return logits;
}

std::vector<ClassId> classes_of_row(const std::vector<std::vector<std::vector<double>>>& networks,
                                    const std::vector<ClassId>& class_of, bool likeliest_first) {
  const int width = static_cast<int>(networks[0].size());
  const Model model = model_with(class_of.size());
  std::vector<ClassScores> scores;
  for (const auto& cells : networks) {
    scores.push_back(decode_semantic_logits({logits_of(cells)}, {model, class_of, {width, 1, width, 1, 1, 1}, likeliest_first}));
  }
  const Image<ClassId> image = most_likely(average(std::move(scores), 1), width, 1);
  return {image.pixels().begin(), image.pixels().end()};
}

TEST(SemanticLogits, LikeliestFirstDoesNotAddUpWhatTheLabelSetLacksOrTakesForOne) {
  const std::vector<ClassId> class_of = {kA, ClassId::kUnknown, ClassId::kUnknown, kB, kB};
  const std::vector<std::vector<double>> cells = {
      {0.4, 0.3, 0.25, 0.025, 0.025},  // the two that the label set lacks together have more than A
      {0.3, 0.45, 0.05, 0.1, 0.1},     // one that the label set lacks is the likeliest
      {0.35, 0.05, 0.05, 0.3, 0.25},   // B in two parts
  };
  EXPECT_EQ(classes_of_row({cells}, class_of, true), (std::vector<ClassId>{kA, ClassId::kUnknown, kA}));
  EXPECT_EQ(classes_of_row({cells}, class_of, false), (std::vector<ClassId>{ClassId::kUnknown, ClassId::kUnknown, kB}));
}

TEST(Average, OfSeveralNetworksLikeliestFirstTakesTheHighestOfEachForAClass) {
  const std::vector<ClassId> class_of = {kA, ClassId::kUnknown, ClassId::kUnknown, kB, kB};
  const std::vector<std::vector<double>> one = {
      {0.4, 0.3, 0.25, 0.025, 0.025},
      {0.2, 0.7, 0.06, 0.02, 0.02},  // of what the label set lacks at most .7 and .2; A .2 and .6
      {0.35, 0.05, 0.05, 0.3, 0.25},
  };
  const std::vector<std::vector<double>> other = {
      {0.4, 0.25, 0.3, 0.025, 0.025},  // of what the label set lacks at most .3 and .3, together .55 and .55; A .4
      {0.6, 0.1, 0.2, 0.05, 0.05},
      {0.4, 0.05, 0.05, 0.25, 0.25},  // A .35 and .4, B at most .3 and .25, its parts together .55 and .5
  };
  EXPECT_EQ(classes_of_row({one, other}, class_of, true), (std::vector<ClassId>{kA, ClassId::kUnknown, kA}));
  EXPECT_EQ(classes_of_row({one, other}, class_of, false), (std::vector<ClassId>{ClassId::kUnknown, ClassId::kUnknown, kB}));
}

TEST(SemanticLogits, SurvivesAbsurdLogits) {
  const Model model = model_with(kClassOf.size());
  Tensor logits = random_logits(6, 5, 7, 1e30F);
  logits.values[0] = std::numeric_limits<float>::quiet_NaN();
  logits.values[40] = std::numeric_limits<float>::infinity();
  logits.values[80] = -std::numeric_limits<float>::infinity();
  const ClassScores scores = decode_semantic_logits({logits}, {model, kClassOf, {7, 5, 7, 5, 1, 1}});
  const Image<ClassId> image = most_likely(scores, 7, 5);
  for (const ClassId id : image.pixels()) EXPECT_TRUE(id == kA || id == kB || id == ClassId::kUnknown);
}

TEST(SemanticLogits, RefusesOutputsOfAnotherKind) {
  const Model model = model_with(kClassOf.size());
  const DecodeContext context{model, kClassOf, {7, 5, 7, 5, 1, 1}};
  EXPECT_THAT(error_of([&] { decode_semantic_logits({}, context); }), HasSubstr("nothing"));
  EXPECT_THAT(error_of([&] { decode_semantic_logits({random_logits(5, 5, 7, 1)}, context); }), HasSubstr("1 x 5 x 5 x 7"));
  EXPECT_THAT(error_of([&] {
                decode_semantic_logits({Tensor{{1, 6}, std::vector<float>(6)}}, context);
              }),
              HasSubstr("tiny.toml"));
}

// Probabilities at random, of as many classes, on a grid that covers the same image as every other grid of this ratio.
ClassScores random_scores(std::vector<ClassId> classes, int width, int height, double cells_per_px, unsigned seed) {
  std::mt19937 random(seed);
  ClassScores scores{std::move(classes), width, height, cells_per_px, cells_per_px, {}};
  const std::size_t cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  for (std::size_t i = 0; i < cells; ++i) {
    float sum = 0;
    std::vector<float> cell;
    for (std::size_t k = 0; k < scores.classes.size(); ++k) sum += cell.emplace_back(static_cast<float>(random() % 1000 + 1));
    for (const float p : cell) scores.values.push_back(p / sum);
  }
  return scores;
}

// A network's score of a class at a place of its own grid, between cells; 0 of a class that it does not know.
double naive_at(const ClassScores& scores, ClassId id, double x, double y) {
  const auto found = std::find(scores.classes.begin(), scores.classes.end(), id);
  if (found == scores.classes.end()) return 0;
  const auto k = static_cast<std::size_t>(found - scores.classes.begin());
  x = std::clamp(x, 0.0, scores.width - 1.0);
  y = std::clamp(y, 0.0, scores.height - 1.0);
  double sum = 0;
  for (int v = 0; v < scores.height; ++v) {
    for (int u = 0; u < scores.width; ++u) {
      const double share = std::max(0.0, 1 - std::abs(x - u)) * std::max(0.0, 1 - std::abs(y - v));
      sum += share * double{scores.values[static_cast<std::size_t>(v * scores.width + u) * scores.classes.size() + k]};
    }
  }
  return sum;
}

TEST(Average, IsTheMeanOfWhatTheNetworksSayInEveryCellOfTheFinestGrid) {
  constexpr float kUnknownShare = 0.7F;
  constexpr auto kC = static_cast<ClassId>(2);
  const std::vector<ClassScores> networks = {random_scores({ClassId::kUnknown, kA, kB}, 5, 4, 0.25, 1),
                                             random_scores({ClassId::kUnknown, kC, kB, kA}, 15, 12, 0.75, 2),
                                             random_scores({ClassId::kUnknown, kC}, 10, 8, 0.5, 3)};
  for (std::size_t count = 1; count <= networks.size(); ++count) {
    const std::vector<ClassScores> some(networks.begin(), networks.begin() + static_cast<std::ptrdiff_t>(count));
    const ClassScores mean = average(some, kUnknownShare);
    const ClassScores& finest = count == 1 ? networks[0] : networks[1];
    ASSERT_EQ(mean.width, finest.width);
    ASSERT_EQ(mean.height, finest.height);
    EXPECT_EQ(mean.cells_per_px_x, finest.cells_per_px_x);
    ASSERT_EQ(mean.classes.size(), count == 1 ? 3U : 4U);
    ASSERT_EQ(mean.classes[0], ClassId::kUnknown);
    for (std::size_t i = 0; i < mean.values.size(); ++i) {
      const std::size_t cell = i / mean.classes.size();
      const ClassId id = mean.classes[i % mean.classes.size()];
      const double x = (static_cast<double>(cell % static_cast<std::size_t>(mean.width)) + 0.5) / mean.cells_per_px_x;
      const double y = (static_cast<double>(cell / static_cast<std::size_t>(mean.width)) + 0.5) / mean.cells_per_px_y;
      double expected = 0;
      for (const ClassScores& network : some) {
        expected += naive_at(network, id, x * network.cells_per_px_x - 0.5, y * network.cells_per_px_y - 0.5);
      }
      expected *= (id == ClassId::kUnknown ? double{kUnknownShare} : 1.0) / static_cast<double>(count);
      ASSERT_NEAR(mean.values[i], expected, 1e-5) << count << " networks, cell " << cell << ", class " << number(id);
    }
  }
}

TEST(Average, DoesNotDependOnTheOrderOfTheNetworks) {
  const ClassScores coarse = random_scores({ClassId::kUnknown, kA, kB}, 5, 4, 0.25, 4);
  const ClassScores fine = random_scores({ClassId::kUnknown, kB}, 20, 16, 1, 5);
  const ClassScores one = average({coarse, fine}, 0.5F);
  const ClassScores other = average({fine, coarse}, 0.5F);
  EXPECT_EQ(one.classes, other.classes);
  EXPECT_EQ(one.values, other.values);
}

TEST(Decoders, AreFoundByNameAndRefuseAnotherTask) {
  Model model = model_with(6);
  const std::vector<Tensor> outputs = {random_logits(6, 5, 7, 1)};
  EXPECT_EQ(recognise(outputs, model, "semantic").decoder, "semantic_logits");
  EXPECT_THAT(error_of([&] { recognise(outputs, model, "instance"); }), HasSubstr("task is 'semantic'"));
  model.decoder = "magic";
  EXPECT_THAT(error_of([&] { recognise(outputs, model, "semantic"); }),
              testing::AllOf(HasSubstr("'magic'"), HasSubstr("semantic_logits")));
}

}  // namespace
}  // namespace panoptic
