// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/network.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/predict/model.h"
#include "panoptic/predict/preprocess.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/places.h"
#include "tests/predict/tiny_onnx.h"
#include "tests/shared_data.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::HasSubstr;

class EveryEngine : public testing::TestWithParam<Engine> {};

INSTANTIATE_TEST_SUITE_P(Network, EveryEngine, testing::ValuesIn(built_in_engines()),
                         [](const auto& engine) { return std::string(name_of(engine.param)); });

std::filesystem::path write_classifier(const std::vector<float>& weights) {
  std::filesystem::path file = fresh_folder() / "tiny.onnx";
  write_file(file, test::color_classifier(4, 2, weights));
  return file;
}

Tensor ramp(std::vector<int> shape) {
  std::size_t count = 1;
  for (const int extent : shape) count *= static_cast<std::size_t>(extent);
  Tensor tensor{std::move(shape), std::vector<float>(count)};
  for (std::size_t i = 0; i < count; ++i) tensor.values[i] = 0.125F * static_cast<float>(i);
  return tensor;
}

TEST_P(EveryEngine, ComputesWhatTheGraphSays) {
  const std::vector<float> weights = {1, 0, 0, 0, 2, 0, 0, 0, -1, 1, 1, 1};
  const Network network(write_classifier(weights), GetParam(), 1);
  const Tensor input = ramp({1, 3, 2, 4});
  const std::vector<Tensor> outputs = network.run(input);
  ASSERT_EQ(outputs.size(), 1U);
  ASSERT_EQ(outputs[0].shape, (std::vector<int>{1, 4, 2, 4}));
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t i = 0; i < 8; ++i) {
      const float expected =
          weights[3 * c] * input.values[i] + weights[3 * c + 1] * input.values[8 + i] + weights[3 * c + 2] * input.values[16 + i];
      EXPECT_NEAR(outputs[0].values[c * 8 + i], expected, 1e-5);
    }
  }
}

TEST_P(EveryEngine, CanBeRunAgainWithTheSameResult) {
  const Network network(write_classifier({1, 2, 3, 4, 5, 6}), GetParam(), 2);
  const Tensor input = ramp({1, 3, 2, 4});
  const std::vector<float> first = network.run(input)[0].values;
  EXPECT_EQ(network.run(input)[0].values, first);
}

TEST_P(EveryEngine, NamesAnAbsentFile) {
  EXPECT_THAT(error_of([] { Network("/nowhere/none.onnx", GetParam()); }), HasSubstr("/nowhere/none.onnx"));
  const std::filesystem::path folder = fresh_folder();
  EXPECT_THAT(error_of([&] { Network(folder, GetParam()); }), HasSubstr(folder.string()));
}

TEST_P(EveryEngine, RefusesFilesThatAreNotOnnx) {
  const std::filesystem::path file = fresh_folder() / "text.onnx";
  for (const std::string& content : {std::string("these are not weights\n"), std::string(), std::string(5000, '\xff')}) {
    write_file(file, content);
    const std::string message = error_of([&] { Network(file, GetParam()); });
    EXPECT_THAT(message, HasSubstr(file.string()));
    EXPECT_THAT(message, HasSubstr("whole ONNX file"));
  }
}

TEST_P(EveryEngine, RefusesATruncatedFile) {
  const std::string whole = test::color_classifier(4, 2, std::vector<float>(300, 1.0F));
  const std::filesystem::path file = fresh_folder() / "cut.onnx";
  for (const double share : {0.02, 0.3, 0.6, 0.9}) {
    write_file(file, std::string_view(whole).substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
    EXPECT_THAT(error_of([&] { Network(file, GetParam()); }), HasSubstr(file.string())) << share;
  }
}

TEST_P(EveryEngine, RefusesAnInputThatDoesNotFit) {
  const std::filesystem::path file = write_classifier({1, 2, 3});
  const Network network(file, GetParam(), 1);
  EXPECT_THAT(error_of([&] { network.run(ramp({1, 5, 2, 4})); }), HasSubstr(file.string()));
}

TEST(Engine, IsFoundByName) {
  EXPECT_EQ(engine_from("auto"), built_in_engines().front());
  EXPECT_EQ(engine_from("opencv"), Engine::kOpenCv);
  EXPECT_THAT(error_of([] { engine_from("tensorrt"); }), HasSubstr("auto, onnxruntime or opencv"));
}

struct RealModel {
  const char* name;
  double tolerance;  // of every output value; 0: only the likeliest class counts
};

class BothEngines : public testing::TestWithParam<RealModel> {};

INSTANTIATE_TEST_SUITE_P(Network, BothEngines,
                         testing::Values(RealModel{"enet_scannet_nyu40", 1e-3}, RealModel{"yolov8n_seg_coco", 1e-3},
                                         RealModel{"deeplabv3_mnv2_ade20k32", 0}),
                         [](const auto& model) { return std::string(model.param.name); });

double largest_difference(const Tensor& a, const Tensor& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) largest = std::max<double>(largest, std::abs(a.values[i] - b.values[i]));
  return largest;
}

double share_of_equal_classes(const Tensor& a, const Tensor& b) {
  const auto classes = static_cast<std::size_t>(a.shape[1]);
  const std::size_t plane = a.values.size() / classes;
  const auto likeliest = [&](const Tensor& logits, std::size_t i) {
    std::size_t best = 0;
    for (std::size_t c = 1; c < classes; ++c) best = logits.values[c * plane + i] > logits.values[best * plane + i] ? c : best;
    return best;
  };
  std::size_t equal = 0;
  for (std::size_t i = 0; i < plane; ++i) equal += likeliest(a, i) == likeliest(b, i) ? 1 : 0;
  return static_cast<double>(equal) / static_cast<double>(plane);
}

TEST_P(BothEngines, AgreeOnRealImages) {
  if (built_in_engines().size() < 2) GTEST_SKIP() << "this build has one engine";
  PANOPTIC_REQUIRE_SHARED("models");
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  Model model = load_model(fmt::format("{}/configs/models/{}.toml", test::source_folder().string(), GetParam().name));
  model.weights_folders = {(test::shared_folder() / "models").string()};
  const Network fast(find_weights(model, Engine::kOnnxRuntime), Engine::kOnnxRuntime);
  const Network portable(find_weights(model, Engine::kOpenCv), Engine::kOpenCv);
  for (const int frame : {0, 250, 480}) {
    const Image<Rgb> image = read_rgb(test::shared_folder() / fmt::format("data/kitchen/frame-{:06}.color.jpg", frame));
    const Tensor input = to_input(image, model.input);
    const std::vector<Tensor> a = fast.run(input);
    const std::vector<Tensor> b = portable.run(input);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].shape, b[i].shape);
      if (GetParam().tolerance > 0) {
        EXPECT_LE(largest_difference(a[i], b[i]), GetParam().tolerance) << "output " << i << ", frame " << frame;
      } else {
        EXPECT_GE(share_of_equal_classes(a[i], b[i]), 0.999) << "frame " << frame;
      }
    }
  }
}

}  // namespace
}  // namespace panoptic
