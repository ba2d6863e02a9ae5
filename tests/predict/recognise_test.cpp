// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "panoptic/predict/decoders.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

constexpr int kWidth = 8;
constexpr int kHeight = 6;
constexpr std::size_t kCells = kWidth * kHeight;
constexpr auto kWall = static_cast<ClassId>(1);
constexpr auto kFloor = static_cast<ClassId>(2);
constexpr auto kChair = static_cast<ClassId>(3);
const std::vector<ClassId> kClassOf = {ClassId::kUnknown, kWall, kFloor, kChair, kWall};
const Placement kPlacement{kWidth, kHeight, kWidth, kHeight, 1, 1};

Model model_with(std::vector<std::string> classes) {
  Model model;
  model.path = "net.toml";
  model.classes = std::move(classes);
  model.input.width = kWidth;
  model.input.height = kHeight;
  return model;
}

Model semantic_model() { return model_with({"other", "wall", "floor", "chair", "brick"}); }

// Logits 1 x 5 x 6 x 8.
Tensor logits() {
  std::mt19937 random(5);
  std::normal_distribution<float> normal(0, 3);
  Tensor tensor{{1, 5, kHeight, kWidth}, std::vector<float>(5 * kCells)};
  for (float& value : tensor.values) value = normal(random);
  return tensor;
}

Tensor softmax(Tensor tensor) {
  for (std::size_t i = 0; i < kCells; ++i) {
    float sum = 0;
    for (std::size_t c = 0; c < 5; ++c) sum += std::exp(tensor.values[c * kCells + i]);
    for (std::size_t c = 0; c < 5; ++c) tensor.values[c * kCells + i] = std::exp(tensor.values[c * kCells + i]) / sum;
  }
  return tensor;
}

Tensor channels_last(const Tensor& tensor) {
  Tensor result{{1, kHeight, kWidth, 5}, std::vector<float>(5 * kCells)};
  for (std::size_t i = 0; i < kCells; ++i) {
    for (std::size_t c = 0; c < 5; ++c) result.values[i * 5 + c] = tensor.values[c * kCells + i];
  }
  return result;
}

Tensor reshaped(Tensor tensor, std::vector<int> shape) {
  tensor.shape = std::move(shape);
  return tensor;
}

Image<ClassId> classes_in(const std::vector<Tensor>& outputs, const Model& model = semantic_model()) {
  const Reading reading = recognise(outputs, model, "semantic");
  return most_likely(*decode(outputs, reading, {model, kClassOf, kPlacement}).scores, kWidth, kHeight);
}

TEST(Recognise, ReadsEveryLayoutOfClassValuesAlike) {
  const Tensor nchw = logits();
  const Tensor nhwc = channels_last(nchw);
  const Image<ClassId> expected = classes_in({nchw});
  EXPECT_EQ(classes_in({nhwc}), expected);
  EXPECT_EQ(classes_in({reshaped(nchw, {5, kHeight, kWidth})}), expected);
  EXPECT_EQ(classes_in({reshaped(nhwc, {kHeight, kWidth, 5})}), expected);
  EXPECT_EQ(classes_in({reshaped(nchw, {1, 5, kCells})}), expected);
  EXPECT_EQ(classes_in({reshaped(nhwc, {1, kCells, 5})}), expected);
  EXPECT_EQ(classes_in({reshaped(nhwc, {kCells, 5})}), expected);
}

TEST(Recognise, TakesSharesThatSumToOneForProbabilities) {
  EXPECT_EQ(classes_in({softmax(logits())}), classes_in({logits()}));
  EXPECT_EQ(recognise({softmax(logits())}, semantic_model(), "semantic").numbers, Numbers::kProbabilities);
  Tensor log = softmax(logits());
  for (float& value : log.values) value = std::log(value);
  EXPECT_EQ(classes_in({log}), classes_in({logits()}));
}

TEST(Recognise, TakesWholeNumbersForClassesOfProbabilityOne) {
  Tensor numbers{{1, kHeight, kWidth}, std::vector<float>(kCells), "classes", true};
  for (std::size_t i = 0; i < kCells; ++i) numbers.values[i] = static_cast<float>(i % 5);
  numbers.values[7] = 255;
  const Image<ClassId> expected = classes_in({numbers});
  for (std::size_t i = 0; i < kCells; ++i) EXPECT_EQ(expected[i], i == 7 ? ClassId::kUnknown : kClassOf[i % 5]) << i;
  Tensor floats = numbers;
  floats.is_whole = false;
  EXPECT_EQ(classes_in({reshaped(floats, {1, 1, kHeight, kWidth})}), expected);
  EXPECT_EQ(classes_in({reshaped(floats, {1, kHeight, kWidth, 1})}), expected);
  EXPECT_EQ(classes_in({reshaped(numbers, {kHeight, kWidth})}), expected);
  numbers.values[0] = 5;
  EXPECT_THAT(error_of([&] { classes_in({numbers}); }), HasSubstr("class number 5"));
}

TEST(Recognise, TakesTheMainOutputBesideAuxiliaryOnes) {
  Tensor main = logits();
  main.name = "y";
  Tensor opposite = main;
  opposite.name = "aux";
  for (float& value : opposite.values) value = -value;
  const Image<ClassId> expected = classes_in({main});
  EXPECT_EQ(classes_in({main, opposite}), expected);
  EXPECT_EQ(classes_in({opposite, main}), expected);
  const Tensor coarse{{1, 5, 3, 4}, std::vector<float>(60, 1.0F), "z"};
  EXPECT_EQ(classes_in({coarse, main}), expected);
}

TEST(Recognise, RefusesWhatCanBeReadInTwoWaysAndObeysTheDescription) {
  Tensor one = logits();
  one.name = "a";
  Tensor other = logits();
  other.name = "b";
  for (float& value : other.values) value = -value;
  Model model = semantic_model();
  EXPECT_THAT(error_of([&] {
                classes_in({one, other}, model);
              }),
              testing::AllOf(HasSubstr("semantic = \"a\" or semantic = \"b\""), HasSubstr("net.toml")));
  model.outputs["semantic"] = "b";
  EXPECT_EQ(classes_in({one, other}, model), classes_in({other}));
  model.outputs["semantic"] = "c";
  EXPECT_THAT(error_of([&] { classes_in({one, other}, model); }), HasSubstr("no output of that name"));
}

TEST(Recognise, SaysThatABackgroundMayBeMissing) {
  const Model model = model_with({"wall", "floor", "chair", "brick"});
  EXPECT_THAT(error_of([&] { recognise({logits()}, model, "semantic"); }),
              testing::AllOf(HasSubstr("4 classes"), HasSubstr("background")));
  const Tensor single{{1, 1, kHeight, kWidth}, std::vector<float>(kCells, 0.5F)};
  EXPECT_THAT(error_of([&] { recognise({single}, semantic_model(), "semantic"); }), HasSubstr("5 classes"));
}

TEST(Recognise, ReadsOnePlaneAsTheProbabilityOfOneClass) {
  const Model model = model_with({"wall"});
  Tensor plane{{1, 1, kHeight, kWidth}, std::vector<float>(kCells, -4.0F)};
  plane.values[3] = 4;
  const Reading reading = recognise({plane}, model, "semantic");
  const std::vector<ClassId> class_of = {kWall};
  const Image<ClassId> classes = most_likely(*decode({plane}, reading, {model, class_of, kPlacement}).scores, kWidth, kHeight);
  for (std::size_t i = 0; i < kCells; ++i) EXPECT_EQ(classes[i], i == 3 ? kWall : ClassId::kUnknown) << i;
}

TEST(Recognise, APixelWithoutAPreferenceIsUnknown) {
  const Tensor zeros{{1, 5, kHeight, kWidth}, std::vector<float>(5 * kCells)};
  const Tensor fifths{{1, 5, kHeight, kWidth}, std::vector<float>(5 * kCells, 0.2F)};
  for (const Tensor& dead : {zeros, fifths}) {
    const Image<ClassId> classes = classes_in({dead});
    for (const ClassId id : classes.pixels()) EXPECT_EQ(id, ClassId::kUnknown);
  }
}

TEST(Recognise, RefusesGridsThatDoNotCoverTheInput) {
  Model model = semantic_model();
  const Tensor transposed = reshaped(logits(), {1, 5, kWidth, kHeight});
  EXPECT_THAT(error_of([&] { recognise({transposed}, model, "semantic"); }), HasSubstr("a grid of 6 x 8 does not cover"));
  model.outputs["layout"] = "nchw";
  EXPECT_EQ(recognise({transposed}, model, "semantic").height, kWidth);
  const Tensor classifier{{1, 5, 1, 1}, std::vector<float>(5)};
  EXPECT_THAT(error_of([&] { recognise({classifier}, semantic_model(), "semantic"); }), HasSubstr("whole images"));
}

// Classes and boxes of a YOLO of 64 classes have 64 planes each; every value is the same.
TEST(Recognise, ADetectorThatCanBeReadInTwoWaysIsNoSemanticNetwork) {
  std::vector<std::string> names;
  for (int i = 0; i < 64; ++i) names.push_back("class " + std::to_string(i));
  Model model = model_with(names);
  model.input.width = model.input.height = 64;
  std::vector<Tensor> outputs = {Tensor{{1, 32, 16, 16}, std::vector<float>(32 * 256, 1.0F)}};
  for (const int side : {8, 4}) {
    const auto cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    for (const int channels : {64, 64, 32}) {
      outputs.push_back(Tensor{{1, channels, side, side}, std::vector<float>(static_cast<std::size_t>(channels) * cells, 1.0F)});
    }
  }
  for (const char* task : {"semantic", "instance", "panoptic"}) {
    EXPECT_THAT(error_of([&] { recognise(outputs, model, task); }), HasSubstr("order = \"boxes classes masks\"")) << task;
  }
}

TEST(Recognise, SaysThatADetectorHasNoMasksAndWhichDecoderWouldDo) {
  Model model = model_with({"cup", "chair"});
  const std::vector<Tensor> boxes = {Tensor{{1, 6, 84}, std::vector<float>(504, 0.25F)}};
  EXPECT_THAT(error_of([&] { recognise(boxes, model, "instance"); }), HasSubstr("without masks"));
  model = semantic_model();
  model.decoder = "yolo_seg";
  EXPECT_THAT(error_of([&] { recognise({logits()}, model, "semantic"); }), HasSubstr("leave out decoder = \"yolo_seg\""));
}

}  // namespace
}  // namespace panoptic
