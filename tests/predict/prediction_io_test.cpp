// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/prediction_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/predictor.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::AllOf;
using testing::HasSubstr;

constexpr auto kWall = static_cast<ClassId>(3);
constexpr auto kChair = static_cast<ClassId>(7);
constexpr auto kCup = static_cast<ClassId>(20);

LabelSet labels() {
  return {"room",
          {{kWall, "wall", false, {1, 2, 3}}, {kChair, "chair", true, {4, 5, 6}}, {kCup, "cup \"blue\"", true, {7, 8, 9}}}};
}

Segmentation random_segmentation(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> share(0, 1);
  Segmentation result{Image<std::uint16_t>(13, 9), {}};
  for (int i = 0; i < 300; ++i) {
    const float p = share(random);
    result.segments.push_back({i % 2 == 0 ? kChair : kCup, share(random), {{kChair, p}, {kCup, 1 - p}}});
  }
  result.segments.push_back({kWall, 1, {}});
  std::uniform_int_distribution<std::uint16_t> segment(0, 301);
  for (std::size_t i = 0; i < result.segment_at.size(); ++i) result.segment_at[i] = segment(random);
  return result;
}

std::filesystem::path written(std::int64_t index = 5) {
  std::filesystem::path folder = fresh_folder();
  PredictionWriter(folder, labels(), "test").write(index, random_segmentation(1));
  return folder;
}

Frame frame_number(std::int64_t index, int width = 13, int height = 9) {
  Frame frame;
  frame.index = index;
  frame.color = Image<Rgb>(width, height);
  return frame;
}

TEST(Predictions, ComeBackExactlyAsWritten) {
  const std::filesystem::path folder = fresh_folder();
  PredictionWriter writer(folder, labels(), "test");
  for (const unsigned i : {0U, 7U, 1234567U}) writer.write(i, random_segmentation(i));
  const auto predictor = make_file_predictor(folder);
  for (const unsigned i : {0U, 7U, 1234567U}) EXPECT_EQ(predictor->predict(frame_number(i)), random_segmentation(i));
  ASSERT_EQ(predictor->labels().classes().size(), 3U);
  EXPECT_EQ(predictor->labels().name(), "room");
  EXPECT_EQ(predictor->labels().name_of(kCup), "cup \"blue\"");
  EXPECT_EQ(predictor->labels().find(kCup)->color, (Rgb{7, 8, 9}));
  EXPECT_TRUE(predictor->labels().is_stuff(kWall));
}

TEST(Predictions, KeepWhatWasNotToldApartAndWhatClassesCanBe) {
  const std::filesystem::path folder = fresh_folder();
  const LabelSet room("room", {{kWall, "wall", false, {}, 0, false},
                               {kChair, "chair", true, {}, 1.6, false},
                               {kCup, "table", true, {}, 0.1 + 0.2, true}});
  Segmentation written = random_segmentation(3);
  for (std::size_t i = 0; i < written.segments.size(); i += 3) written.segments[i].is_whole_class = true;
  PredictionWriter(folder, room, "test").write(4, written);
  const auto predictor = make_file_predictor(folder);
  EXPECT_EQ(predictor->predict(frame_number(4)), written);
  ASSERT_EQ(predictor->labels().classes().size(), 3U);
  for (const LabelClass& c : room.classes()) {
    EXPECT_EQ(predictor->labels().find(c.id)->max_size_m, c.max_size_m) << c.name;
    EXPECT_EQ(predictor->labels().is_support(c.id), c.is_support) << c.name;
  }
}

TEST(Predictions, WithoutWholeClassesWhatWasNotToldApartIsUnknownAndStuffStaysWhateverItIsCalled) {
  const std::filesystem::path folder = fresh_folder();
  const Segmentation written{Image<std::uint16_t>(4, 1, {0, 1, 2, 3}),
                             {{kChair, 1, {}, true}, {kCup, 0.5F, {{kCup, 1}}}, {kWall, 1, {}, true}}};
  PredictionWriter(folder, labels(), "test").write(4, written);
  const Segmentation read = make_file_predictor(folder, labels(), false)->predict(frame_number(4, 4, 1));
  EXPECT_EQ(read, (Segmentation{Image<std::uint16_t>(4, 1, {0, 0, 1, 2}), {{kCup, 0.5F, {{kCup, 1}}}, {kWall, 1, {}, true}}}));
  EXPECT_EQ(make_file_predictor(folder, labels())->predict(frame_number(4, 4, 1)), written);
}

TEST(Predictions, WithoutWholeClassesAreWhatWouldHaveBeenPredictedWithoutThem) {
  constexpr int kFrames = 30;
  std::mt19937 random(12);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const std::vector<ClassId> classes = {ClassId::kUnknown, kWall, kChair, kCup};
  const std::filesystem::path folder = fresh_folder();
  PredictionWriter writer(folder, labels(), "test");
  std::vector<Segmentation> expected;
  for (int i = 0; i < kFrames; ++i) {
    Image<ClassId> semantic(13, 9);
    for (std::size_t k = 0; k < semantic.size(); ++k) semantic[k] = classes[static_cast<std::size_t>(below(4))];
    std::vector<Instance> instances(static_cast<std::size_t>(below(4)));
    for (Instance& instance : instances) {
      instance.segment = {kChair, 0.5F, {}};
      instance.x0 = below(10);
      instance.y0 = below(7);
      instance.mask = Image<std::uint8_t>(below(6) + 1, below(6) + 1, 1);
    }
    writer.write(i, fuse(semantic, instances, labels()));
    expected.push_back(fuse(semantic, instances, labels(), {.keep_whole_classes = false}));
  }
  const auto with = make_file_predictor(folder);
  const auto without = make_file_predictor(folder, {}, false);
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(without->predict(frame_number(i)), expected[static_cast<std::size_t>(i)]) << i;
    EXPECT_NE(with->predict(frame_number(i)), expected[static_cast<std::size_t>(i)]) << i << ": nothing to leave out";
  }
}

TEST(Predictions, AreEmptyForFramesThatWereNotWritten) {
  const std::filesystem::path folder = fresh_folder();
  PredictionWriter writer(folder, labels(), "test");
  writer.write(1, random_segmentation(1));
  writer.write(2, Segmentation());
  const auto predictor = make_file_predictor(folder, labels());
  EXPECT_EQ(predictor->predict(frame_number(2)), Segmentation());
  EXPECT_EQ(predictor->predict(frame_number(99)), Segmentation());
}

TEST(PredictionWriter, RefusesWhatTheReaderWould) {
  PredictionWriter writer(fresh_folder(), labels(), "test");
  Segmentation good{Image<std::uint16_t>(4, 3, 1), {{kChair, 0.5F, {{kChair, 1}}}}};
  const auto refusal = [&](auto change, std::int64_t index = 0) {
    Segmentation bad = good;
    change(bad);
    return error_of([&] { writer.write(index, bad); });
  };
  EXPECT_THAT(refusal([](auto&) {}, -1), HasSubstr("negative"));
  EXPECT_THAT(refusal([](auto& s) { s.segment_at[0] = 2; }), HasSubstr("does not exist"));
  EXPECT_THAT(refusal([](auto& s) { s.segments[0].class_id = static_cast<ClassId>(4); }), HasSubstr("class 4"));
  EXPECT_THAT(refusal([](auto& s) { s.segments[0].score = std::nanf(""); }), HasSubstr("score"));
  EXPECT_THAT(refusal([](auto& s) { s.segments[0].class_probabilities[0].probability = 2; }), HasSubstr("probabilities"));
  writer.write(0, good);
  EXPECT_THAT(refusal([](auto& s) { s.segment_at = Image<std::uint16_t>(5, 3); }), HasSubstr("size"));
}

TEST(PredictionWriter, NeverMixesTwoRuns) {
  const std::filesystem::path folder = written();
  EXPECT_THAT(error_of([&] { PredictionWriter(folder, labels(), "test"); }), HasSubstr("already holds predictions"));
}

TEST(PredictionWriter, NamesAFolderThatCannotBeWritten) {
  write_file(fresh_folder() / "file", std::string_view("in the way"));
  const std::filesystem::path blocked = std::filesystem::path(fresh_folder("x")).parent_path() / "files" / "file";
  EXPECT_THAT(error_of([&] { PredictionWriter(blocked / "sub", labels(), "test"); }), HasSubstr(blocked.string()));
}

// Every mistake in predictions.json is named with the file and the member.
TEST(Predictions, RefuseAWrongIndexFile) {
  const std::filesystem::path folder = written();
  const std::filesystem::path file = folder / "predictions.json";
  const Json good = read_json_file(file);
  const auto refusal = [&](auto change) {
    Json bad = good;
    change(bad);
    write_json_file(file, bad);
    std::string message = error_of([&] { make_file_predictor(folder); });
    EXPECT_THAT(message, HasSubstr(file.string()));
    return message;
  };
  EXPECT_THAT(refusal([](Json& j) { j.erase("format"); }), HasSubstr("format"));
  EXPECT_THAT(refusal([](Json& j) { j["format"] = "other"; }), HasSubstr("format"));
  EXPECT_THAT(refusal([](Json& j) { j["version"] = 2; }), HasSubstr("version"));
  EXPECT_THAT(refusal([](Json& j) { j["image"]["width"] = 1000000; }), HasSubstr("image.width"));
  EXPECT_THAT(refusal([](Json& j) { j["image"]["height"] = 0.5; }), HasSubstr("image.height"));
  EXPECT_THAT(refusal([](Json& j) { j["image"]["height"] = std::numeric_limits<std::uint64_t>::max(); }),
              HasSubstr("image.height"));
  EXPECT_THAT(refusal([](Json& j) { j["label_set"] = 3; }), HasSubstr("label_set"));
  EXPECT_THAT(refusal([](Json& j) { j["label_set"]["classes"] = {{"a", 1}}; }), HasSubstr("label_set.classes"));
  EXPECT_THAT(refusal([](Json& j) { j["label_set"]["classes"][1]["id"] = 0; }), HasSubstr("label_set.classes[1].id"));
  EXPECT_THAT(refusal([](Json& j) { j["label_set"]["classes"][1]["id"] = 3; }), HasSubstr("share id 3"));
  EXPECT_THAT(refusal([](Json& j) { j["label_set"]["classes"][0]["color"] = {1, 2}; }), HasSubstr("red, green, blue"));
  EXPECT_THAT(refusal([](Json& j) { j["label_set"]["classes"][0]["max_size_m"] = -1; }), HasSubstr("max_size_m"));
  EXPECT_THAT(refusal([](Json& j) { j["label_set"]["classes"][0]["is_support"] = 2; }), HasSubstr("is_support"));
  EXPECT_THAT(refusal([](Json& j) { j = Json::array(); }), HasSubstr("the whole must be an object"));
}

TEST(Predictions, RefuseAWrongFrameFile) {
  const std::filesystem::path folder = written(5);
  const std::filesystem::path file = folder / "000005.json";
  const Json good = read_json_file(file);
  const auto predictor = make_file_predictor(folder);
  const auto refusal = [&](auto change) {
    Json bad = good;
    change(bad);
    write_json_file(file, bad);
    std::string message = error_of([&] { predictor->predict(frame_number(5)); });
    EXPECT_THAT(message, HasSubstr("000005."));
    return message;
  };
  EXPECT_THAT(refusal([](Json& j) { j["frame"] = 6; }), HasSubstr("frame"));
  EXPECT_THAT(refusal([](Json& j) { j["segments"][0]["class_id"] = 4; }), HasSubstr("segments[0].class_id"));
  EXPECT_THAT(refusal([](Json& j) { j["segments"][0]["class_id"] = -7; }), HasSubstr("segments[0].class_id"));
  EXPECT_THAT(refusal([](Json& j) { j["segments"][1]["score"] = nullptr; }), HasSubstr("segments[1].score"));
  EXPECT_THAT(refusal([](Json& j) { j["segments"][1]["score"] = 1.5; }), HasSubstr("segments[1].score"));
  EXPECT_THAT(refusal([](Json& j) { j["segments"][0]["class_probabilities"][1]["class_id"] = 7; }),
              HasSubstr("above the one before"));
  EXPECT_THAT(refusal([](Json& j) { j["segments"][2]["is_whole_class"] = "yes"; }), HasSubstr("segments[2].is_whole_class"));
  EXPECT_THAT(refusal([](Json& j) { j["segments"] = Json::array(); }), HasSubstr("segment"));
  write_file(file, std::string_view("{\"frame\": 5, \"segm"));
  EXPECT_THAT(error_of([&] { predictor->predict(frame_number(5)); }), HasSubstr("000005.json"));
}

TEST(Predictions, RefuseAWrongPicture) {
  const std::filesystem::path folder = written(5);
  const std::filesystem::path file = folder / "000005.png";
  const std::string good = read_file(file);
  const auto predictor = make_file_predictor(folder);
  const auto refusal = [&] { return error_of([&] { predictor->predict(frame_number(5)); }); };
  write_file(file, std::string_view(good).substr(0, good.size() / 2));
  EXPECT_THAT(refusal(), HasSubstr(file.string()));
  write_file(file, std::string_view("not a picture at all, but some text"));
  EXPECT_THAT(refusal(), AllOf(HasSubstr(file.string()), HasSubstr("not a PNG")));
  std::string huge = good;
  huge[16] = huge[20] = '\x7f';  // a header that claims 2 billion pixels a side
  write_file(file, huge);
  EXPECT_THAT(refusal(), HasSubstr("13 x 9"));
  write_png(file, Image<std::uint16_t>(9, 13));
  EXPECT_THAT(refusal(), HasSubstr("9 x 13"));
  write_png(file, Image<std::uint16_t>(13, 9, 302));
  EXPECT_THAT(refusal(), HasSubstr("does not exist"));
  write_png(file, Image<Rgb>(13, 9));
  EXPECT_THAT(refusal(), HasSubstr("one channel"));
  std::filesystem::remove(file);
  EXPECT_THAT(refusal(), HasSubstr(file.string()));
}

TEST(Predictions, RefuseARecordingOfAnotherSize) {
  const auto predictor = make_file_predictor(written(5));
  EXPECT_THAT(error_of([&] { predictor->predict(frame_number(5, 640, 480)); }),
              AllOf(HasSubstr("13 x 9"), HasSubstr("640 x 480")));
}

TEST(Predictions, RefuseAnotherLabelSet) {
  const std::filesystem::path folder = written();
  EXPECT_THAT(error_of([&] { make_file_predictor(folder, load_label_set("indoor")); }),
              AllOf(HasSubstr("'room'"), HasSubstr("'indoor'")));
}

TEST(Predictions, AreLookedForWhereTheUserSays) {
  const std::filesystem::path folder = fresh_folder();
  EXPECT_THAT(error_of([&] { make_file_predictor(folder / "none"); }), HasSubstr((folder / "none").string()));
  EXPECT_THAT(error_of([&] { make_file_predictor(folder); }), HasSubstr("predictions.json"));
}

// Cutting or changing any byte of the JSON files gives an Error or an answer, never a crash.
TEST(Predictions, SurviveDamage) {
  const std::filesystem::path folder = written(5);
  std::mt19937 random(11);
  for (const char* name : {"predictions.json", "000005.json", "000005.png"}) {
    const std::string good = read_file(folder / name);
    for (int round = 0; round < 150; ++round) {
      std::string bad = good;
      bad[random() % bad.size()] = static_cast<char>(random());
      if (round % 3 == 0) bad.resize(random() % bad.size());
      write_file(folder / name, bad);
      try {
        const auto predictor = make_file_predictor(folder);
        EXPECT_EQ(check(predictor->predict(frame_number(5)), 13, 9).reason, "");
      } catch (const Error&) {
        SUCCEED();
      }
    }
    write_file(folder / name, good);
  }
}

}  // namespace
}  // namespace panoptic
