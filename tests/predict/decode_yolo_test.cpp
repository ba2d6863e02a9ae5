// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "panoptic/predict/decoders.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

constexpr int kInput = 64;  // pixels; grids of 8, 4 and 2 cells
constexpr int kBins = 16;
constexpr int kPrototypes = 6;
constexpr int kPrototypeSide = 16;
constexpr auto kCup = static_cast<ClassId>(5);
constexpr auto kChair = static_cast<ClassId>(8);
const std::vector<ClassId> kClassOf = {kChair, ClassId::kUnknown, kCup, kChair};

Model yolo_model() {
  Model model;
  model.path = "yolo.toml";
  model.task = "instance";
  model.decoder = "yolo_seg";
  model.classes.resize(kClassOf.size());
  model.input.width = kInput;
  model.input.height = kInput;
  return model;
}

std::vector<Instance> decode_yolo_seg(std::vector<Tensor> outputs, const DecodeContext& context) {
  const Reading reading = recognise(outputs, context.model, "instance");
  return decode(std::move(outputs), reading, context).instances;
}

// Outputs in which about one cell in twelve holds an object.
std::vector<Tensor> random_outputs(unsigned seed) {
  std::mt19937 random(seed);
  const auto tensor = [&](int channels, int side, float mean, float spread) {
    std::normal_distribution<float> normal(mean, spread);
    Tensor result{{1, channels, side, side}, {}};
    const auto cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    result.values.resize(static_cast<std::size_t>(channels) * cells);
    for (float& value : result.values) value = normal(random);
    return result;
  };
  std::vector<Tensor> outputs;
  for (const int side : {8, 4, 2}) outputs.push_back(tensor(4 * kBins, side, 0, 2));
  for (const int side : {8, 4, 2}) outputs.push_back(tensor(static_cast<int>(kClassOf.size()), side, -4, 1.5));
  for (const int side : {8, 4, 2}) outputs.push_back(tensor(kPrototypes, side, 0, 1));
  outputs.push_back(tensor(kPrototypes, kPrototypeSide, 0, 1));
  return outputs;
}

double at(const Tensor& tensor, int channel, int y, int x) {
  const auto height = static_cast<std::size_t>(tensor.shape[2]);
  const auto width = static_cast<std::size_t>(tensor.shape[3]);
  return tensor
      .values[(static_cast<std::size_t>(channel) * height + static_cast<std::size_t>(y)) * width + static_cast<std::size_t>(x)];
}

double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

struct NaiveObject {
  ClassId class_id;
  double score;
  double left, top, right, bottom;
  std::map<ClassId, double> probabilities;
  Image<std::uint8_t> mask;  // of the whole image
};

double naive_side(const Tensor& boxes, int side, int y, int x) {
  double sum = 0;
  double weighted = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    const double e = std::exp(at(boxes, side * kBins + bin, y, x));
    sum += e;
    weighted += e * bin;
  }
  return weighted / sum;
}

// A cell of one of the three grids.
struct Cell {
  std::size_t stride_index;
  int x, y;
};

// Bilinear interpolation of the mask scores at a place on the prototypes' grid.
double naive_mask_score(const std::vector<Tensor>& outputs, const Cell& cell, double x, double y) {
  x = std::clamp(x, 0.0, kPrototypeSide - 1.0);
  y = std::clamp(y, 0.0, kPrototypeSide - 1.0);
  double value = 0;
  const int left = static_cast<int>(x);
  const int top = static_cast<int>(y);
  for (int j = top; j <= std::min(top + 1, kPrototypeSide - 1); ++j) {
    for (int i = left; i <= std::min(left + 1, kPrototypeSide - 1); ++i) {
      const double share = (1 - std::abs(x - i)) * (1 - std::abs(y - j));
      double dot = 0;
      for (int k = 0; k < kPrototypes; ++k) {
        dot += at(outputs[6 + cell.stride_index], k, cell.y, cell.x) * at(outputs[9], k, j, i);
      }
      value += share * sigmoid(dot);
    }
  }
  return value;
}

Image<std::uint8_t> naive_mask(const std::vector<Tensor>& outputs, const Cell& cell, const NaiveObject& object,
                               const Placement& p) {
  Image<std::uint8_t> mask(p.image_width, p.image_height);
  const double ratio = static_cast<double>(kPrototypeSide) / kInput;
  for (int v = 0; v < p.image_height; ++v) {
    for (int u = 0; u < p.image_width; ++u) {
      if (u + 0.5 < object.left || u + 0.5 >= object.right || v + 0.5 < object.top || v + 0.5 >= object.bottom) continue;
      const double score =
          naive_mask_score(outputs, cell, (u + 0.5) * p.scale_x * ratio - 0.5, (v + 0.5) * p.scale_y * ratio - 0.5);
      mask(u, v) = score > 0.5 ? 1 : 0;
    }
  }
  return mask;
}

NaiveObject naive_object(const std::vector<Tensor>& outputs, const Cell& cell, const Placement& p) {
  const Tensor& boxes = outputs[cell.stride_index];
  const double stride = static_cast<double>(kInput) / boxes.shape[3];
  NaiveObject object{};
  for (std::size_t c = 0; c < kClassOf.size(); ++c) {
    const double score = sigmoid(at(outputs[3 + cell.stride_index], static_cast<int>(c), cell.y, cell.x));
    if (kClassOf[c] != ClassId::kUnknown) object.probabilities[kClassOf[c]] += score;
    if (score <= object.score) continue;
    object.score = score;
    object.class_id = kClassOf[c];
  }
  object.left = (cell.x + 0.5 - naive_side(boxes, 0, cell.y, cell.x)) * stride / p.scale_x;
  object.top = (cell.y + 0.5 - naive_side(boxes, 1, cell.y, cell.x)) * stride / p.scale_y;
  object.right = (cell.x + 0.5 + naive_side(boxes, 2, cell.y, cell.x)) * stride / p.scale_x;
  object.bottom = (cell.y + 0.5 + naive_side(boxes, 3, cell.y, cell.x)) * stride / p.scale_y;
  object.mask = naive_mask(outputs, cell, object, p);
  return object;
}

double naive_overlap(const NaiveObject& a, const NaiveObject& b) {
  const double width = std::min(a.right, b.right) - std::max(a.left, b.left);
  const double height = std::min(a.bottom, b.bottom) - std::max(a.top, b.top);
  const double common = std::max(0.0, width) * std::max(0.0, height);
  const double areas = (a.right - a.left) * (a.bottom - a.top) + (b.right - b.left) * (b.bottom - b.top);
  return common / (areas - common);
}

std::vector<NaiveObject> naive_objects(const std::vector<Tensor>& outputs, const Placement& p) {
  std::vector<NaiveObject> objects;
  for (std::size_t s = 0; s < 3; ++s) {
    for (int i = 0; i < outputs[s].shape[2] * outputs[s].shape[3]; ++i) {
      const int side = outputs[s].shape[3];
      const int row = i / side;
      const NaiveObject object = naive_object(outputs, {s, i % side, row}, p);
      if (object.class_id != ClassId::kUnknown && object.score >= 0.3) objects.push_back(object);
    }
  }
  std::stable_sort(objects.begin(), objects.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<NaiveObject> kept;
  for (const NaiveObject& object : objects) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const NaiveObject& better) {
      return better.class_id == object.class_id && naive_overlap(better, object) > 0.5;
    });
    if (!covered) kept.push_back(object);
  }
  std::erase_if(kept, [](const NaiveObject& o) { return std::count(o.mask.pixels().begin(), o.mask.pixels().end(), 1) == 0; });
  return kept;
}

Image<std::uint8_t> whole_mask(const Instance& instance, int width, int height) {
  Image<std::uint8_t> whole(width, height);
  for (int y = 0; y < instance.mask.height(); ++y) {
    for (int x = 0; x < instance.mask.width(); ++x) whole(instance.x0 + x, instance.y0 + y) = instance.mask(x, y);
  }
  return whole;
}

void expect_equal(const Instance& instance, const NaiveObject& expected, const Placement& p) {
  EXPECT_EQ(instance.segment.class_id, expected.class_id);
  EXPECT_NEAR(instance.segment.score, expected.score, 1e-5);
  double total = 0;
  for (const auto& [id, score] : expected.probabilities) total += score;
  for (const ClassProbability& c : instance.segment.class_probabilities) {
    EXPECT_NEAR(c.probability, expected.probabilities.at(c.class_id) / total, 2e-3);
  }
  const Image<std::uint8_t> mask = whole_mask(instance, p.image_width, p.image_height);
  int differing = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) differing += mask[i] != expected.mask[i] ? 1 : 0;
  EXPECT_LE(differing, 1);  // a pixel whose score is 0.5 within rounding
}

class YoloPlacement : public testing::TestWithParam<Placement> {};

// Images as large as the input, letterboxed, and enlarged by a fraction.
INSTANTIATE_TEST_SUITE_P(YoloSeg, YoloPlacement,
                         testing::Values(Placement{64, 64, 64, 64, 1, 1}, Placement{64, 48, 64, 64, 1, 1},
                                         Placement{40, 27, 64, 64, 1.6, 43.0 / 27}, Placement{200, 150, 64, 64, 0.32, 0.32}));

TEST_P(YoloPlacement, EqualsTheNaiveReference) {
  const Model model = yolo_model();
  std::size_t found = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const std::vector<Tensor> outputs = random_outputs(seed);
    const std::vector<Instance> instances = decode_yolo_seg(outputs, {model, kClassOf, GetParam()});
    const std::vector<NaiveObject> expected = naive_objects(outputs, GetParam());
    ASSERT_EQ(instances.size(), expected.size()) << "seed " << seed;
    for (std::size_t i = 0; i < expected.size(); ++i) expect_equal(instances[i], expected[i], GetParam());
    found += expected.size();
  }
  EXPECT_GT(found, 20U);
}

TEST(YoloSeg, GivesProbabilitiesThatSumToOneSortedByClass) {
  const Model model = yolo_model();
  const std::vector<Instance> instances = decode_yolo_seg(random_outputs(1), {model, kClassOf, {64, 64, 64, 64, 1, 1}});
  ASSERT_FALSE(instances.empty());
  for (const Instance& instance : instances) {
    float sum = 0;
    ClassId before = ClassId::kUnknown;
    for (const ClassProbability& c : instance.segment.class_probabilities) {
      EXPECT_GT(c.class_id, before);
      before = c.class_id;
      sum += c.probability;
    }
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

TEST(YoloSeg, DropsSmallMasksAndKeepsTheBest) {
  Model model = yolo_model();
  const std::vector<Tensor> outputs = random_outputs(5);
  const DecodeContext context{model, kClassOf, {64, 64, 64, 64, 1, 1}};
  const std::vector<Instance> all = decode_yolo_seg(outputs, context);
  ASSERT_GT(all.size(), 3U);
  model.thresholds.max_instances = 2;
  const std::vector<Instance> best = decode_yolo_seg(outputs, context);
  ASSERT_EQ(best.size(), 2U);
  EXPECT_EQ(best[1].segment, all[1].segment);
  model.thresholds.min_area_px = 64 * 64 + 1;
  EXPECT_TRUE(decode_yolo_seg(outputs, context).empty());
}

TEST(YoloSeg, SurvivesAbsurdOutputs) {
  const Model model = yolo_model();
  std::vector<Tensor> outputs = random_outputs(3);
  const float absurd[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(), 1e38F};
  std::size_t n = 0;
  for (Tensor& tensor : outputs) {
    for (std::size_t i = 0; i < tensor.values.size(); i += 3) tensor.values[i] = absurd[n++ % std::size(absurd)];
  }
  for (const Instance& instance : decode_yolo_seg(outputs, {model, kClassOf, {64, 48, 64, 64, 1, 1}})) {
    EXPECT_GE(instance.x0, 0);
    EXPECT_LE(instance.x0 + instance.mask.width(), 64);
    EXPECT_LE(instance.y0 + instance.mask.height(), 48);
  }
}

TEST(YoloSeg, RefusesOutputsOfAnotherKind) {
  const Model model = yolo_model();
  const DecodeContext context{model, kClassOf, {64, 64, 64, 64, 1, 1}};
  const auto broken = [&](auto change) {
    std::vector<Tensor> outputs = random_outputs(1);
    change(outputs);
    return error_of([&] { decode_yolo_seg(outputs, context); });
  };
  EXPECT_THAT(broken([](auto& o) { o.clear(); }), HasSubstr("0 outputs"));
  EXPECT_THAT(broken([](auto& o) { o.pop_back(); }), HasSubstr("prototypes"));
  EXPECT_THAT(broken([](auto& o) { o[4].shape = {1, 5, 4, 4}; }), HasSubstr("64, 5 and 6 channels"));
  EXPECT_THAT(broken([](auto& o) { o[0].shape = {1, 66, 8, 8}; }), HasSubstr("66"));
  EXPECT_THAT(broken([](auto& o) { o[9].shape = {1, 3, 16, 32}; }), HasSubstr("yolo.toml"));
  EXPECT_THAT(broken([](auto& o) { o[6].shape = {64}; }), HasSubstr("yolo.toml"));
}

void expect_same(const std::vector<Instance>& a, const std::vector<Instance>& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_FALSE(a.empty());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].segment.class_id, b[i].segment.class_id);
    EXPECT_NEAR(a[i].segment.score, b[i].segment.score, 1e-5);
    EXPECT_EQ(a[i].x0, b[i].x0);
    EXPECT_EQ(a[i].mask, b[i].mask);
  }
}

const Placement kSquare{kInput, kInput, kInput, kInput, 1, 1};

TEST(YoloSeg, ReadsHeadsInAnyOrder) {
  const Model model = yolo_model();
  const DecodeContext context{model, kClassOf, kSquare};
  const std::vector<Tensor> outputs = random_outputs(1);
  const std::vector<Instance> expected = decode_yolo_seg(outputs, context);
  std::vector<Tensor> mixed = outputs;
  std::mt19937 random(3);
  for (int i = 0; i < 5; ++i) {
    std::shuffle(mixed.begin(), mixed.end(), random);
    expect_same(decode_yolo_seg(mixed, context), expected);
  }
}

TEST(YoloSeg, TakesClassValuesWithinZeroAndOneForProbabilities) {
  const Model model = yolo_model();
  const DecodeContext context{model, kClassOf, kSquare};
  std::vector<Tensor> outputs = random_outputs(1);
  const std::vector<Instance> expected = decode_yolo_seg(outputs, context);
  for (std::size_t s = 3; s < 6; ++s) {
    for (float& value : outputs[s].values) value = static_cast<float>(sigmoid(value));
  }
  expect_same(decode_yolo_seg(outputs, context), expected);
}

// The heads after the steps that Ultralytics' export adds: boxes as centre and size, classes as probabilities, strides joined.
std::vector<Tensor> raw_outputs(const std::vector<Tensor>& heads, bool channels_last) {
  std::vector<std::vector<float>> boxes;
  for (std::size_t s = 0; s < 3; ++s) {
    const int side = heads[s].shape[3];
    for (int i = 0; i < side * side; ++i) {
      const Cell cell{s, i % side, i / side};
      const NaiveObject object = naive_object(heads, cell, kSquare);
      std::vector<float> numbers = {
          static_cast<float>((object.left + object.right) / 2), static_cast<float>((object.top + object.bottom) / 2),
          static_cast<float>(object.right - object.left), static_cast<float>(object.bottom - object.top)};
      for (int c = 0; c < 4; ++c) numbers.push_back(static_cast<float>(sigmoid(at(heads[3 + s], c, cell.y, cell.x))));
      for (int m = 0; m < kPrototypes; ++m) numbers.push_back(static_cast<float>(at(heads[6 + s], m, cell.y, cell.x)));
      boxes.push_back(numbers);
    }
  }
  const int count = static_cast<int>(boxes.size());
  const int numbers = static_cast<int>(boxes[0].size());
  Tensor tensor{channels_last ? std::vector<int>{1, count, numbers} : std::vector<int>{1, numbers, count}, {}};
  for (int i = 0; i < count * numbers; ++i) {
    const auto box = static_cast<std::size_t>(channels_last ? i / numbers : i % count);
    const auto number = static_cast<std::size_t>(channels_last ? i % numbers : i / count);
    tensor.values.push_back(boxes[box][number]);
  }
  return {tensor, heads[9]};
}

TEST(YoloSeg, ReadsUltralyticsOwnExportAsItsHeads) {
  const Model model = yolo_model();
  const DecodeContext context{model, kClassOf, kSquare};
  const std::vector<Tensor> heads = random_outputs(2);
  const std::vector<Instance> expected = decode_yolo_seg(heads, context);
  for (const bool channels_last : {false, true}) {
    std::vector<Tensor> raw = raw_outputs(heads, channels_last);
    expect_same(decode_yolo_seg(raw, context), expected);
    std::swap(raw[0], raw[1]);
    expect_same(decode_yolo_seg(raw, context), expected);
  }
}

TEST(YoloSeg, ReadsAnExportThatSuppressesItself) {
  const Model model = yolo_model();
  const DecodeContext context{model, kClassOf, kSquare};
  Tensor rows{{1, 300, 6 + kPrototypes}, std::vector<float>(300 * (6 + kPrototypes))};
  const float found[] = {8, 8, 40, 24, 0.9F, 2, 1, 0, 0, 0, 0, 0};
  std::copy(std::begin(found), std::end(found), rows.values.begin());
  Tensor prototypes{{1, kPrototypes, 16, 16}, std::vector<float>(kPrototypes * 256)};
  std::fill_n(prototypes.values.begin(), 256, 5.0F);
  const std::vector<Instance> instances = decode_yolo_seg({rows, prototypes}, context);
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].segment.class_id, kCup);
  EXPECT_FLOAT_EQ(instances[0].segment.score, 0.9F);
  EXPECT_EQ(instances[0].x0, 8);
  EXPECT_EQ(instances[0].mask.width(), 32);
  EXPECT_EQ(instances[0].mask.height(), 16);
}

TEST(YoloSeg, TellsBoxesFromClassesOfEqualNumberByNameOrRefuses) {
  Model model = yolo_model();
  model.decoder.clear();
  const std::vector<ClassId> class_of(64, kCup);
  model.classes.resize(64);
  std::vector<Tensor> outputs = random_outputs(1);
  for (std::size_t s = 3; s < 6; ++s) outputs[s] = Tensor{outputs[s - 3].shape, outputs[s - 3].values};
  EXPECT_THAT(error_of([&] { recognise(outputs, model, "instance"); }), HasSubstr("order = \"boxes classes masks\""));
  for (std::size_t s = 0; s < 3; ++s) {
    outputs[s].name = "/model.22/cv3." + std::to_string(s) + "/Conv_output_0";
    outputs[s + 3].name = "/model.22/cv2." + std::to_string(s) + "/Conv_output_0";
  }
  EXPECT_THAT(recognise(outputs, model, "instance").roles, testing::ElementsAre(3, 4, 5, 0, 1, 2, 6, 7, 8, 9));
  for (Tensor& output : outputs) output.name.clear();
  model.outputs["order"] = "classes boxes masks";
  EXPECT_THAT(recognise(outputs, model, "instance").roles, testing::ElementsAre(3, 4, 5, 0, 1, 2, 6, 7, 8, 9));
}

}  // namespace
}  // namespace panoptic
