// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predictor.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <map>
#include <thread>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/predict/network.h"
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

constexpr auto kRed = static_cast<ClassId>(1);
constexpr auto kBall = static_cast<ClassId>(2);

LabelSet color_labels() { return {"colors", {{kRed, "red", false, {}}, {kBall, "ball", true, {}}}}; }

// A network that takes red pixels for "red" (stuff), green ones for "ball" (a thing) and blue ones for "sky" (not in the set).
NetworkOptions color_network(const std::string& extra = "") {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "colors.onnx", test::color_classifier(8, 4, {9, 0, 0, 0, 9, 0, 0, 0, 9}));
  write_file(folder / "colors.toml", R"(name = "colors"
task = "semantic"
decoder = "semantic_logits"
weights = "colors.onnx"
classes = ["red", "ball", "sky"]
)" + extra + "[input]\nwidth = 8\nheight = 4\n");
  NetworkOptions options;
  options.semantic = {(folder / "colors.toml").string()};
  options.unknown_share = 1;
  return options;
}

Frame frame_of(Image<Rgb> color) {
  Frame frame;
  frame.color = std::move(color);
  return frame;
}

TEST(NetworkPredictor, KeepsStuffAndLeavesThingsWithoutInstanceUnknownAsInThePaper) {
  for (const Engine engine : built_in_engines()) {
    NetworkOptions options = color_network();
    options.segmentation.keep_whole_classes = false;
    options.engine = name_of(engine);
    const auto predictor = make_network_predictor(options, color_labels());
    Image<Rgb> color(8, 4, Rgb{255, 0, 0});
    color(1, 1) = {0, 255, 0};
    color(5, 2) = {0, 0, 255};
    const Segmentation result = predictor->predict(frame_of(color));
    ASSERT_EQ(result.segments.size(), 1U);
    EXPECT_EQ(result.segments[0].class_id, kRed);
    for (int v = 0; v < 4; ++v) {
      for (int u = 0; u < 8; ++u) EXPECT_EQ(result.segment_at(u, v), color(u, v).r == 255 ? 1 : 0) << u << " " << v;
    }
  }
}

TEST(NetworkPredictor, AveragesSemanticNetworks) {
  NetworkOptions options = color_network();
  options.semantic.push_back(options.semantic[0]);
  Image<Rgb> color(8, 4, Rgb{255, 0, 0});
  color(1, 1) = {0, 255, 0};
  const Segmentation one = make_network_predictor(color_network(), color_labels())->predict(frame_of(color));
  EXPECT_EQ(make_network_predictor(options, color_labels())->predict(frame_of(color)), one);
  ASSERT_EQ(one.segments.size(), 2U);
  EXPECT_TRUE(one.segments[1].is_whole_class);
}

TEST(NetworkPredictor, LikeliestFirstLooksForTheNetworksOwnClassBeforeTheLabelSets) {
  const Image<Rgb> color(8, 4, Rgb{200, 215, 200});  // ball .46, red .27, and sky, which is taken for red, .27
  for (const bool likeliest_first : {false, true}) {
    NetworkOptions options = color_network("[class_map.colors]\nred = \"red\"\nball = \"ball\"\nsky = \"red\"\n");
    options.likeliest_first = likeliest_first;
    const Segmentation result = make_network_predictor(options, color_labels())->predict(frame_of(color));
    ASSERT_EQ(result.segments.size(), 1U);
    EXPECT_EQ(result.segments[0].class_id, likeliest_first ? kBall : kRed);
  }
}

TEST(NetworkPredictor, GivesNothingForAFrameWithoutColor) {
  EXPECT_EQ(make_network_predictor(color_network(), color_labels())->predict(Frame()), Segmentation());
}

TEST(NetworkPredictor, RefusesWhatCannotWorkBeforeTheFirstFrame) {
  EXPECT_THAT(error_of([] { make_network_predictor({}, color_labels()); }), HasSubstr("--semantic"));
  EXPECT_THAT(error_of([] { make_network_predictor({.semantic = {"/nowhere/x.toml"}}, color_labels()); }),
              HasSubstr("/nowhere/x.toml"));

  NetworkOptions as_instance = color_network();
  as_instance.instance = as_instance.semantic[0];
  as_instance.semantic.clear();
  EXPECT_THAT(error_of([&] { make_network_predictor(as_instance, color_labels()); }), HasSubstr("task is 'semantic'"));

  NetworkOptions wrong_size = color_network();
  const std::string text = read_file(wrong_size.semantic[0]);
  write_file(wrong_size.semantic[0], text.substr(0, text.find("[input]")) + "[input]\nwidth = 12\nheight = 4\n");
  wrong_size.engine = name_of(built_in_engines().front());
  if (built_in_engines().size() > 1) {
    EXPECT_THAT(error_of([&] { make_network_predictor(wrong_size, color_labels()); }), HasSubstr("[input]"));
  }

  const NetworkOptions no_weights = color_network();
  std::filesystem::remove(std::filesystem::path(no_weights.semantic[0]).parent_path() / "colors.onnx");
  EXPECT_THAT(error_of([&] { make_network_predictor(no_weights, color_labels()); }), HasSubstr("$PANOPTIC_MODELS"));
}

TEST(NetworkPredictor, RefusesADecoderThatDoesNotReadTheOutputs) {
  NetworkOptions options = color_network();
  std::string text = read_file(options.semantic[0]);
  text.replace(text.find("\"semantic\""), 10, "\"instance\"");
  text.replace(text.find("semantic_logits"), 15, "yolo_seg");
  write_file(options.semantic[0], text);
  options.instance = options.semantic[0];
  options.semantic.clear();
  EXPECT_THAT(error_of([&] { make_network_predictor(options, color_labels()); }),
              testing::AllOf(HasSubstr("yolo_seg"), HasSubstr("1 outputs"), HasSubstr("colors.toml")));
}

// The shipped descriptions, with their weights in the shared folder unless the environment says where.
std::string shipped(const char* name) {
  ::setenv("PANOPTIC_MODELS", (test::shared_folder() / "models").c_str(), 0);
  return fmt::format("{}/configs/models/{}.toml", test::source_folder().string(), name);
}

// The picture with its segments in colour and their borders in white.
Image<Rgb> overlay(const ImageView<Rgb>& color, const Segmentation& segmentation, const LabelSet& labels) {
  Image<Rgb> picture = color.copied();
  for (int v = 1; v < color.height(); ++v) {
    for (int u = 1; u < color.width(); ++u) {
      const std::uint16_t segment = segmentation.segment_at(u, v);
      if (segment == 0) continue;
      const Segment& s = segmentation.segments[segment - 1U];
      const auto object = static_cast<PanopticId>(labels.first_thing() + segment);
      const Rgb paint = labels.is_thing(s.class_id) ? color_of(object, labels) : labels.find(s.class_id)->color;
      const bool border = segmentation.segment_at(u - 1, v) != segment || segmentation.segment_at(u, v - 1) != segment;
      const auto blend = [](int a, int b) { return static_cast<std::uint8_t>((a + b) / 2); };
      const Rgb c = color(u, v);
      picture(u, v) = border ? Rgb{255, 255, 255} : Rgb{blend(c.r, paint.r), blend(c.g, paint.g), blend(c.b, paint.b)};
    }
  }
  return picture;
}

// Pixels per class name, and the overlay for a person to look at.
std::map<std::string, int> pixels_per_class(Predictor& predictor, const std::filesystem::path& image, const std::string& name) {
  const Frame frame = frame_of(read_rgb(image));
  const Segmentation result = predictor.predict(frame);
  EXPECT_EQ(check(result, frame.color.width(), frame.color.height()).reason, "");
  const std::filesystem::path picture = fresh_folder("pictures") / (name + ".png");
  write_png(picture, overlay(frame.color, result, predictor.labels()));
  std::cout << "look at " << picture << " with PANOPTIC_KEEP_TEST_FILES=1\n";
  std::map<std::string, int> pixels;
  for (const std::uint16_t segment : result.segment_at.pixels()) {
    if (segment != 0) ++pixels[std::string(predictor.labels().name_of(result.segments[segment - 1U].class_id))];
  }
  return pixels;
}

// Read once for the tests that share it.
Predictor& indoor_predictor() {
  static const auto kPredictor = make_network_predictor(
      {.semantic = {shipped("enet_scannet_nyu40")}, .instance = shipped("yolov8n_seg_coco")}, load_label_set("indoor"));
  return *kPredictor;
}

TEST(NetworkPredictor, SeesTheKitchen) {
  PANOPTIC_REQUIRE_SHARED("models");
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  const auto pixels =
      pixels_per_class(indoor_predictor(), test::shared_folder() / "data/kitchen/frame-000000.color.jpg", "kitchen");
  EXPECT_GT(pixels.at("table"), 50000);
  EXPECT_GT(pixels.at("chair"), 10000);
  EXPECT_GT(pixels.at("cup"), 500);
  EXPECT_GT(pixels.at("floor"), 20000);
}

TEST(NetworkPredictor, ItsHalvesAtOnceJoinToWhatItPredicts) {
  PANOPTIC_REQUIRE_SHARED("models");
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  const Frame frame = frame_of(read_rgb(test::shared_folder() / "data/kitchen/frame-000000.color.jpg"));
  const auto halves = indoor_predictor().halves();
  ASSERT_TRUE(halves.has_value());
  Image<ClassId> classes;
  std::thread beside([&] { classes = halves->semantic(frame.color); });
  const std::vector<Instance> instances = halves->instances(frame.color);
  beside.join();
  EXPECT_EQ(halves->join(classes, instances), indoor_predictor().predict(frame));
}

TEST(NetworkPredictor, OfOneNetworkHasNoHalves) {
  EXPECT_FALSE(make_network_predictor(color_network(), color_labels())->halves().has_value());
}

TEST(NetworkPredictor, SeesTheOffice) {
  PANOPTIC_REQUIRE_SHARED("models");
  PANOPTIC_REQUIRE_SHARED("data/hololens");
  const auto predictor = make_network_predictor(
      {.semantic = {shipped("deeplabv3_mnv2_ade20k32")}, .instance = shipped("yolov8n_seg_coco")}, load_label_set("home"));
  const auto pixels = pixels_per_class(*predictor, test::shared_folder() / "data/hololens/images/00102.png", "office");
  EXPECT_GT(pixels.at("plant"), 20000);
  EXPECT_GT(pixels.at("table"), 30000);
  EXPECT_GT(pixels.at("wall"), 10000);
}

TEST(NetworkPredictor, ObeysTheScoreThreshold) {
  PANOPTIC_REQUIRE_SHARED("models");
  PANOPTIC_REQUIRE_SHARED("data/kitchen");
  const Frame frame = frame_of(read_rgb(test::shared_folder() / "data/kitchen/frame-000000.color.jpg"));
  const auto scores_above = [&](double threshold) {
    const auto predictor = make_network_predictor({.instance = shipped("yolov8n_seg_coco"), .score_threshold = threshold},
                                                  load_label_set("scannet20"));
    const Segmentation result = predictor->predict(frame);
    EXPECT_TRUE(
        std::all_of(result.segments.begin(), result.segments.end(), [&](const Segment& s) { return s.score >= threshold; }));
    return result.segments.size();
  };
  EXPECT_GT(scores_above(0.1), scores_above(0.7));
  EXPECT_EQ(scores_above(1), 0U);
}

}  // namespace
}  // namespace panoptic
