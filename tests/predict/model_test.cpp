// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/model.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "panoptic/base/files.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::HasSubstr;

constexpr const char* kHead = R"(name = "tiny"
task = "semantic"
decoder = "semantic_logits"
weights = "tiny.onnx"
)";
constexpr const char* kClasses = "classes = [\"wall\", \"couch\", \"lamp\"]\n";
constexpr const char* kInput = "[input]\nwidth = 4\nheight = 2\n";

std::filesystem::path write_model(const std::string& text) {
  std::filesystem::path file = fresh_folder() / "tiny.toml";
  write_file(file, text);
  return file;
}

LabelSet room_labels() {
  return {"room", {{static_cast<ClassId>(3), "wall", false, {}}, {static_cast<ClassId>(7), "sofa", true, {}}}};
}

// Sets an environment variable while it lives.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    ::setenv(name, value.c_str(), 1);
  }
  ~Environment() { before_.empty() ? ::unsetenv(name_) : ::setenv(name_, before_.c_str(), 1); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  std::string before_;
};

TEST(Model, IsReadFromItsDescription) {
  const Model model = load_model(write_model(std::string(kHead) + kClasses + R"([input]
width = 328
height = 256
resize = "letterbox"
pad_value = 114
channels = "bgr"
scale = 0.5
mean = [1, 2, 3]
std = [4, 5, 6]
[thresholds]
score = 0.25
[class_map.room]
couch = "sofa"
)"));
  EXPECT_EQ(model.name, "tiny");
  EXPECT_EQ(model.input.width, 328);
  EXPECT_EQ(model.input.resize, "letterbox");
  EXPECT_EQ(model.input.channels, "bgr");
  EXPECT_EQ(model.input.std, (std::vector<double>{4, 5, 6}));
  EXPECT_FLOAT_EQ(model.thresholds.score, 0.25F);
  EXPECT_EQ(model.classes.size(), 3U);
  EXPECT_EQ(model.class_maps.at("room").at("couch"), "sofa");
}

TEST(Model, TakesClassesFromAFile) {
  const std::filesystem::path file = write_model(std::string(kHead) + "classes_file = \"labels.txt\"\n" + kInput);
  write_file(file.parent_path() / "labels.txt", std::string_view("wall\r\ndining table \n\nlamp"));
  EXPECT_EQ(load_model(file).classes, (std::vector<std::string>{"wall", "dining table", "lamp"}));
}

TEST(Model, RefusesMistakesWithFileAndLine) {
  const std::string head = kHead;
  EXPECT_THAT(error_of([&] { load_model(write_model(head + "clases = []\n" + kClasses + kInput)); }),
              testing::AllOf(HasSubstr("tiny.toml:5"), HasSubstr("clases"), HasSubstr("classes")));
  EXPECT_THAT(error_of([&] { load_model(write_model(head + kInput)); }), HasSubstr("classes"));
  EXPECT_THAT(error_of([&] { load_model(write_model(head + kClasses)); }), HasSubstr("input.width"));
  EXPECT_THAT(error_of([&] { load_model(write_model(head + "classes = [\"a\", \"a\"]\n" + kInput)); }), HasSubstr("one name"));
  EXPECT_THAT(error_of([&] { load_model(write_model(head + kClasses + kInput + "mean = [1, 2]\n")); }), HasSubstr("input.mean"));
  EXPECT_THAT(error_of([&] { load_model(write_model(head + kClasses + kInput + "std = [1, 0, 1]\n")); }), HasSubstr("input.std"));
  EXPECT_THAT(error_of([&] { load_model(write_model(head + kClasses + "[input]\nwidth = 99999\nheight = 2\n")); }),
              HasSubstr("input.width"));
  EXPECT_THAT(error_of([&] { load_model(fresh_folder() / "absent.toml"); }), HasSubstr("absent.toml"));
}

TEST(Model, RefusesARoleOfOutputsThatThereIsNot) {
  const std::string text = std::string(kHead) + kClasses + kInput + "[outputs]\nmaks = \"y\"\n";
  EXPECT_THAT(error_of([&] { load_model(write_model(text)); }), testing::AllOf(HasSubstr("'maks'"), HasSubstr("masks")));
}

TEST(Weights, AreFoundBesideTheDescriptionThenInTheVariableThenInItsFolders) {
  const std::filesystem::path file = write_model(std::string(kHead) + "weights_folders = [\"../nets\"]\n" + kClasses + kInput);
  const std::filesystem::path beside = file.parent_path() / "tiny.onnx";
  const std::filesystem::path variable = fresh_folder("variable") / "tiny.onnx";
  const std::filesystem::path folder = fresh_folder("nets") / "tiny.onnx";
  const Environment models("PANOPTIC_MODELS", variable.parent_path().string());
  const Model model = load_model(file);

  const std::string message = error_of([&] { find_weights(model, Engine::kOpenCv); });
  for (const auto& place : {beside, variable, folder}) EXPECT_THAT(message, HasSubstr(place.string()));
  EXPECT_THAT(message, HasSubstr("$PANOPTIC_MODELS"));

  for (const auto& place : {folder, variable, beside}) {
    write_file(place, std::string_view("weights"));
    EXPECT_EQ(find_weights(model, Engine::kOpenCv), place);
  }
}

TEST(Weights, MayDifferForOpenCv) {
  const std::filesystem::path file = write_model(std::string(kHead) + "weights_opencv = \"other.onnx\"\n" + kClasses + kInput);
  for (const char* name : {"tiny.onnx", "other.onnx"}) write_file(file.parent_path() / name, std::string_view("weights"));
  EXPECT_EQ(find_weights(load_model(file), Engine::kOpenCv).filename(), "other.onnx");
  EXPECT_EQ(find_weights(load_model(file), Engine::kOnnxRuntime).filename(), "tiny.onnx");
}

TEST(ClassMap, GivesEachNetworkClassItsCounterpart) {
  const Model model =
      load_model(write_model(std::string(kHead) + kClasses + kInput + "[class_map.room]\nwall = \"wall\"\ncouch = \"sofa\"\n"));
  EXPECT_EQ(map_classes(model, room_labels()),
            (std::vector<ClassId>{static_cast<ClassId>(3), static_cast<ClassId>(7), ClassId::kUnknown}));
}

TEST(ClassMap, FallsBackToNamesThatMeanTheSame) {
  const Model model = load_model(write_model(std::string(kHead) + kClasses + kInput));
  EXPECT_EQ(map_classes(model, room_labels()),
            (std::vector<ClassId>{static_cast<ClassId>(3), static_cast<ClassId>(7), ClassId::kUnknown}));
  const LabelSet strange("strange", {{static_cast<ClassId>(1), "dragon", true, {}}});
  EXPECT_THAT(error_of([&] { map_classes(model, strange); }),
              testing::AllOf(HasSubstr("tiny.toml"), HasSubstr("[class_map.strange]")));
}

TEST(ClassMap, RefusesClassesThatDoNotExist) {
  const std::string text = std::string(kHead) + kClasses + kInput + "[class_map.room]\n\"wall\" = \"wall\"\n";
  const Model no_source = load_model(write_model(text + "sofa = \"sofa\"\n"));
  EXPECT_THAT(error_of([&] { map_classes(no_source, room_labels()); }),
              testing::AllOf(HasSubstr("tiny.toml:11"), HasSubstr("'sofa'"), HasSubstr("wall, couch, lamp")));
  const Model no_target = load_model(write_model(text + "couch = \"settee\"\n"));
  EXPECT_THAT(error_of([&] { map_classes(no_target, room_labels()); }),
              testing::AllOf(HasSubstr("tiny.toml:11"), HasSubstr("'settee'"), HasSubstr("wall, sofa")));
}

class ShippedModel : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Model, ShippedModel,
                         testing::Values("enet_scannet_nyu40", "deeplabv3_mnv2_ade20k32", "yolov8n_seg_coco"));

TEST_P(ShippedModel, MapsToEveryShippedLabelSet) {
  const Model model = load_model(fmt::format("{}/configs/models/{}.toml", test::source_folder().string(), GetParam()));
  for (const char* name : {"indoor", "home", "scannet20"}) {
    EXPECT_TRUE(model.class_maps.contains(name)) << name;
    const LabelSet labels = load_label_set(name);
    EXPECT_NO_THROW(map_classes(model, labels)) << name;
  }
}

}  // namespace
}  // namespace panoptic
