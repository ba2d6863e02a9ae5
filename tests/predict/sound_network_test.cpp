// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Whole networks as people export them, from the file to the predictor, and what it says of those that are of no use.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "panoptic/base/files.h"
#include "panoptic/predict/model_guess.h"
#include "panoptic/predictor.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/predict/onnx_writer.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using test::OnnxWriter;
using testing::HasSubstr;

constexpr auto kWall = static_cast<ClassId>(1);
constexpr auto kSofa = static_cast<ClassId>(2);

LabelSet room() { return {"room", {{kWall, "wall", false, {}}, {kSofa, "sofa", true, {}}}}; }

std::string describe(const OnnxWriter& writer, const std::string& classes) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "net.onnx", writer.text());
  write_file(folder / "net.toml",
             "name = \"net\"\nweights = \"net.onnx\"\nclasses = " + classes + "\n[input]\nwidth = 8\nheight = 6\n");
  return (folder / "net.toml").string();
}

Frame picture() {
  Image<Rgb> color(8, 6, Rgb{200, 0, 0});
  for (int v = 0; v < 6; ++v) color(7, v) = {0, 200, 0};
  Frame frame;
  frame.color = std::move(color);
  return frame;
}

// Red is the first class, green the second, blue the third; scaled with `gain`.
OnnxWriter colors(float gain) {
  OnnxWriter writer;
  writer.input("x", {1, 3, 6, 8});
  test::classifier(writer, "x", "y", {gain, 0, 0, 0, gain, 0, 0, 0, gain}).output("y", {1, 3, 6, 8});
  return writer;
}

TEST(NetworkPredictor, NeedsNeitherTaskNorDecoderNorClassMap) {
  const auto predictor = make_network_predictor({.semantic = {describe(colors(9), R"(["wall-brick", "couch", "sky"])")}}, room());
  const Segmentation seen = predictor->predict(picture());
  ASSERT_EQ(seen.segments.size(), 2U);
  EXPECT_EQ(seen.segments[0].class_id, kWall);
  EXPECT_EQ(seen.segments[1].class_id, kSofa);
  EXPECT_TRUE(predictor->take_warnings().empty());
  EXPECT_EQ(predictor->report().trouble, "");
}

TEST(NetworkPredictor, WarnsAtOnceOfANetworkThatSaysNothingAndFailsItAtTheEnd) {
  const auto predictor = make_network_predictor({.semantic = {describe(colors(0), R"(["wall", "sofa", "sky"])")}}, room());
  predictor->predict(picture());
  EXPECT_THAT(predictor->take_warnings(), testing::ElementsAre(HasSubstr("no label that counts")));
  predictor->predict(picture());
  EXPECT_TRUE(predictor->take_warnings().empty());
  EXPECT_THAT(predictor->report().trouble, testing::AllOf(HasSubstr("in 2 frames"), HasSubstr("net.toml")));
}

TEST(NetworkPredictor, WarnsOfNumbersThatAreNotFinite) {
  OnnxWriter writer;
  writer.input("x", {1, 3, 6, 8}).constant("nan", {1}, std::vector<float>{std::numeric_limits<float>::quiet_NaN()});
  writer.node("Add", {"x", "nan"}, "y").output("y", {1, 3, 6, 8});
  const auto predictor = make_network_predictor({.semantic = {describe(writer, R"(["wall", "sofa", "sky"])")}}, room());
  EXPECT_TRUE(predictor->predict(picture()).segments.empty());
  EXPECT_THAT(predictor->take_warnings(), testing::Contains(HasSubstr("not finite")));
  EXPECT_THAT(predictor->report().trouble, HasSubstr("not finite in 1 of 1 frames"));
}

TEST(NetworkPredictor, ListsClassesWithoutCounterpartWithTheirShare) {
  const auto predictor = make_network_predictor({.semantic = {describe(colors(9), R"(["wall", "zebra", "sky"])")}}, room());
  predictor->predict(picture());
  EXPECT_THAT(predictor->report().notes, testing::ElementsAre(testing::AllOf(HasSubstr("12.5 %"), HasSubstr("zebra"))));
}

// Two queries over the whole picture: wall on the left, a sofa on the right.
OnnxWriter queries() {
  OnnxWriter writer;
  std::vector<float> masks;
  for (int i = 0; i < 96; ++i) masks.push_back((i < 48) == (i % 8 < 4) ? 9.0F : -9.0F);
  writer.input("x", {1, 3, 6, 8})
      .constant("l", {1, 2, 3}, std::vector<float>{9, 0, 0, 0, 9, 0})
      .constant("m", {1, 2, 6, 8}, masks);
  writer.node("Identity", {"l"}, "pred_logits").node("Identity", {"m"}, "pred_masks");
  return writer.output("pred_logits", {1, 2, 3}).output("pred_masks", {1, 2, 6, 8});
}

TEST(NetworkPredictor, OneNetworkOfQueriesStandsForBoth) {
  if (built_in_engines().size() < 2) GTEST_SKIP() << "a graph of constants is nothing for OpenCV";
  const std::string description = describe(queries(), R"(["wall", "sofa"])");
  const NetworkOptions as_semantic{.semantic = {description}};
  const NetworkOptions as_instance{.instance = description};
  const NetworkOptions as_both{.semantic = {description}, .instance = description};
  for (const NetworkOptions& options : {as_semantic, as_instance, as_both}) {
    const auto predictor = make_network_predictor(options, room());
    EXPECT_FALSE(predictor->halves().has_value());
    const Segmentation seen = predictor->predict(picture());
    ASSERT_EQ(seen.segments.size(), 2U);
    EXPECT_EQ(seen.segments[0].class_id, kSofa);
    EXPECT_FALSE(seen.segments[0].is_whole_class);
    EXPECT_EQ(seen.segments[1].class_id, kWall);
    EXPECT_EQ(seen.segment_at(6, 3), 1);
    EXPECT_EQ(seen.segment_at(1, 3), 2);
  }
}

TEST(ModelGuess, TakesClassesFromTheFileAndWritesADescriptionThatLoads) {
  if (built_in_engines().size() < 2) GTEST_SKIP() << "needs ONNX Runtime";
  const std::filesystem::path folder = fresh_folder();
  OnnxWriter writer = colors(9);
  writer.metadata("names", R"({0: 'wall', 1: "driver's seat", 2: 'sky'})");
  write_file(folder / "net.onnx", writer.text());
  const Model guess = guess_model(folder / "net.onnx", Engine::kOnnxRuntime);
  EXPECT_EQ(guess.classes, (std::vector<std::string>{"wall", "driver's seat", "sky"}));
  EXPECT_EQ(guess.task, "semantic");
  write_file(folder / "net.toml", to_toml(guess, {.task = "semantic", .text = "logits"}));
  const Model read = load_model(folder / "net.toml");
  EXPECT_EQ(read.classes, guess.classes);
  EXPECT_EQ(read.input.width, 8);
  EXPECT_EQ(read.input.height, 6);
}

}  // namespace
}  // namespace panoptic
