// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/predict/network.h"
#include "panoptic/predict/onnx_file.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/predict/onnx_writer.h"

namespace panoptic {
namespace {

using test::classifier;
using test::error_of;
using test::fresh_folder;
using test::OnnxWriter;
using testing::HasSubstr;
using testing::Not;

const std::vector<float> kWeights = {1, 0, 0, 0, 2, 0, 0, 0, -1, 1, 1, 1};

std::filesystem::path write(const OnnxWriter& writer) {
  const std::filesystem::path file = fresh_folder() / "net.onnx";
  write_file(file, writer.text());
  return file;
}

Tensor picture() {
  Tensor tensor{{1, 3, 2, 4}, std::vector<float>(24)};
  for (std::size_t i = 0; i < 24; ++i) tensor.values[i] = static_cast<float>(i);
  return tensor;
}

// The first of the built-in engines is ONNX Runtime, where the build has it.
bool has_onnxruntime() { return built_in_engines().size() > 1; }

std::vector<float> plain_result() {
  OnnxWriter writer;
  writer.input("x", {1, 3, 2, 4});
  classifier(writer, "x", "y", kWeights).output("y", {1, 4, 2, 4});
  return Network(write(writer), Engine::kOpenCv, 1).run(picture())[0].values;
}

TEST(Network, TakesImagesInEveryOrderAndNumber) {
  if (!has_onnxruntime()) GTEST_SKIP() << "OpenCV takes plain inputs only";
  const std::vector<float> expected = plain_result();
  const auto result_of = [&](const OnnxWriter& writer) {
    return Network(write(writer), Engine::kOnnxRuntime, 1).run(picture())[0];
  };
  const std::string last_first = OnnxWriter::integers_attribute("perm", {0, 3, 1, 2});
  for (const std::vector<int>& shape : {std::vector<int>{1, 2, 4, 3}, std::vector<int>{0, 0, 0, 3}}) {
    OnnxWriter writer;
    writer.input("x", shape).node("Transpose", {"x"}, "t", {last_first});
    EXPECT_EQ(result_of(classifier(writer, "t", "y", kWeights).output("y", {1, 4, 2, 4})).values, expected);
  }
  OnnxWriter no_batch;
  no_batch.input("x", {3, 2, 4}).constant("axis", {1}, std::vector<std::int64_t>{0}).node("Unsqueeze", {"x", "axis"}, "t");
  EXPECT_EQ(result_of(classifier(no_batch, "t", "y", kWeights).output("y", {1, 4, 2, 4})).values, expected);
  for (const unsigned type : {test::kBytes, test::kHalves, test::kDoubles}) {
    OnnxWriter writer;
    writer.input("x", {1, 3, 2, 4}, type).node("Cast", {"x"}, "t", {OnnxWriter::integer_attribute("to", test::kFloats)});
    EXPECT_EQ(result_of(classifier(writer, "t", "y", kWeights).output("y", {1, 4, 2, 4})).values, expected) << type;
  }
  for (const unsigned type : {test::kHalves, test::kDoubles, test::kInt64s}) {
    OnnxWriter writer;
    writer.input("x", {1, 3, 0, 0});
    classifier(writer, "x", "l", kWeights).node("Cast", {"l"}, "y", {OnnxWriter::integer_attribute("to", type)});
    const Tensor result = result_of(writer.output("y", {1, 4, 0, 0}, type));
    EXPECT_EQ(result.values, expected) << type;
    EXPECT_EQ(result.is_whole, type == test::kInt64s);
    EXPECT_EQ(result.name, "y");
  }
}

TEST(Network, RefusesInputsThatAreNoColorImage) {
  const auto complaint = [](const std::vector<int>& shape, unsigned type = test::kFloats) {
    OnnxWriter writer;
    writer.input("x", shape, type).node("Identity", {"x"}, "y").output("y", shape, type);
    return error_of([&] { Network(write(writer), built_in_engines().front(), 1); });
  };
  EXPECT_THAT(complaint({1, 1, 4, 4}), HasSubstr("3 channels"));
  EXPECT_THAT(complaint({4, 3, 4, 4}), HasSubstr("batches of 4"));
  EXPECT_THAT(complaint({1, 3}), HasSubstr("1 x 3 x height x width"));
  EXPECT_THAT(complaint({1, 3, 4, 4}, test::kInt64s), HasSubstr("64-bit integers"));
  OnnxWriter fixed;
  fixed.input("x", {1, 3, 4, 4}).node("Identity", {"x"}, "y").output("y", {1, 3, 4, 4});
  const Network network(write(fixed), built_in_engines().front(), 1);
  EXPECT_THAT(error_of([&] { network.run(picture()); }), testing::AllOf(HasSubstr("4 x 4"), HasSubstr("[input] says 4 x 2")));
}

TEST(Network, SaysWhatAFileIsInsteadOfOnnx) {
  const std::filesystem::path file = fresh_folder() / "net.onnx";
  const auto complaint = [&](const std::string& bytes) {
    write_file(file, bytes);
    return error_of([&] { Network(file, built_in_engines().front(), 1); });
  };
  EXPECT_THAT(complaint("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n"), HasSubstr("git lfs pull"));
  EXPECT_THAT(complaint("PK\x03\x04 and so on"), HasSubstr("torch.onnx.export"));
  EXPECT_THAT(complaint("<!DOCTYPE html>"), HasSubstr("web page"));
}

OnnxWriter with_external_weights() {
  OnnxWriter writer;
  writer.input("x", {1, 3, 2, 4}).external("weights", {4, 3, 1, 1}, "net.data");
  writer.node("Conv", {"x", "weights"}, "y", {OnnxWriter::integers_attribute("kernel_shape", {1, 1})}).output("y", {1, 4, 2, 4});
  return writer;
}

TEST(Network, ReadsWeightsFromASecondFileAndMissesIt) {
  const std::vector<float> expected = plain_result();
  const std::filesystem::path file = write(with_external_weights());
  EXPECT_THAT(error_of([&] { Network(file, built_in_engines().front(), 1); }), HasSubstr("net.data"));
  const auto* bytes = reinterpret_cast<const char*>(kWeights.data());
  write_file(file.parent_path() / "net.data", std::string_view(bytes, kWeights.size() * sizeof(float)));
  if (has_onnxruntime()) {
    EXPECT_EQ(Network(file, Engine::kOnnxRuntime, 1).run(picture())[0].values, expected);
  }
  // OpenCV 4.6 divides by zero there.
  EXPECT_THAT(error_of([&] { Network(file, Engine::kOpenCv, 1); }), HasSubstr("second file"));
}

TEST(Network, GivesOutputsInTheOrderOfTheFileWithEveryEngine) {
  for (const Engine engine : built_in_engines()) {
    for (const auto& [first, second] : {std::pair("a", "z"), std::pair("z", "a")}) {
      OnnxWriter writer;
      writer.input("x", {1, 3, 2, 4});
      classifier(writer, "x", "l", kWeights).node("Neg", {"l"}, second).node("Relu", {"l"}, first);
      writer.output(first, {1, 4, 2, 4}).output(second, {1, 4, 2, 4});
      const std::vector<Tensor> outputs = Network(write(writer), engine, 1).run(picture());
      ASSERT_EQ(outputs.size(), 2U);
      EXPECT_EQ(outputs[0].name, first);
      EXPECT_GE(*std::min_element(outputs[0].values.begin(), outputs[0].values.end()), 0) << name_of(engine) << first;
      EXPECT_LT(*std::min_element(outputs[1].values.begin(), outputs[1].values.end()), 0) << name_of(engine) << first;
    }
  }
}

TEST(Network, OpenCvIsRefusedWhereItWouldGiveOtherResults) {
  const auto complaint = [](OnnxWriter& writer) { return error_of([&] { Network(write(writer), Engine::kOpenCv, 1); }); };
  OnnxWriter numbers;
  numbers.input("x", {1, 3, 2, 4}).node("ArgMax", {"x"}, "y", {OnnxWriter::integer_attribute("axis", 1)});
  EXPECT_THAT(complaint(numbers.output("y", {1, 1, 2, 4}, test::kInt64s)), HasSubstr("64-bit integers"));
  OnnxWriter foreign;
  foreign.input("x", {1, 3, 2, 4}).node("MMCVRoiAlign", {"x"}, "y", {}, "mmdeploy").output("y", {1, 3, 2, 4});
  EXPECT_THAT(complaint(foreign), testing::AllOf(HasSubstr("mmdeploy::MMCVRoiAlign"), HasSubstr("networks.engine=onnxruntime")));
}

TEST(Network, GivesTheReasonOfOnnxRuntimeWithoutPathsOfItsBuild) {
  if (!has_onnxruntime()) GTEST_SKIP() << "needs ONNX Runtime";
  OnnxWriter writer(99);
  writer.input("x", {1, 3, 2, 4}).node("Identity", {"x"}, "y").output("y", {1, 3, 2, 4});
  const std::string message = error_of([&] { Network(write(writer), Engine::kOnnxRuntime, 1); });
  EXPECT_THAT(message,
              testing::AllOf(HasSubstr("99"), HasSubstr("opset"), Not(HasSubstr("onnxruntime_src")), Not(HasSubstr("std::"))));
  OnnxWriter foreign;
  foreign.input("x", {1, 3, 2, 4}).node("MMCVRoiAlign", {"x"}, "y", {}, "mmdeploy").output("y", {1, 3, 2, 4});
  EXPECT_THAT(error_of([&] { Network(write(foreign), Engine::kOnnxRuntime, 1); }),
              testing::AllOf(HasSubstr("MMCVRoiAlign"), Not(HasSubstr("/"
                                                                      "onnxruntime_src"))));
}

TEST(Network, RefusesOutputsThatNoMemoryHolds) {
  const auto complaint = [](const std::vector<int>& promised) {
    OnnxWriter writer;
    writer.input("x", {1, 3, 2, 4}).constant("shape", {4}, std::vector<std::int64_t>{1, 64, 4096, 2048});
    writer.node("ConstantOfShape", {"shape"}, "y").output("y", promised, test::kFloats);
    const std::filesystem::path file = write(writer);
    return error_of([&] { Network(file, built_in_engines().front(), 1).run(picture()); });
  };
  EXPECT_THAT(complaint({1, 64, 4096, 2048}), HasSubstr("million numbers"));
  EXPECT_THAT(complaint({2000000000, 2000000000, 2000000000, 2000000000}), HasSubstr("million numbers"));
}

TEST(OnnxFile, HoldsWhatTheFileSays) {
  OnnxWriter writer(17);
  writer.input("image", {0, 3, 2, 4}).metadata("names", "{0: 'a'}").node("Identity", {"image"}, "y").output("y", {0, 3, 2, 4});
  const OnnxFile file = parse_onnx(writer.text(), "net.onnx");
  ASSERT_EQ(file.inputs.size(), 1U);
  EXPECT_EQ(shape_text(file.inputs[0].shape), "image_any x 3 x 2 x 4");
  EXPECT_EQ(file.outputs[0].name, "y");
  EXPECT_EQ(file.operator_set, 17);
  EXPECT_EQ(file.metadata.at("names"), "{0: 'a'}");
  EXPECT_TRUE(file.operators.contains("Identity"));
}

TEST(OnnxFile, SurvivesEveryTruncationAndEveryChangedByte) {
  const std::string whole = with_external_weights().text();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 0x81);
    for (const std::string& bytes : {whole.substr(0, i), changed}) {
      try {
        parse_onnx(bytes, "net.onnx");
      } catch (const Error&) {  // told, not crashed
      }
    }
  }
}

}  // namespace
}  // namespace panoptic
