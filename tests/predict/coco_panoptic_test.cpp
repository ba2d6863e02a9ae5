// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/coco_panoptic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>

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
using testing::Contains;
using testing::HasSubstr;

constexpr auto kWall = static_cast<ClassId>(3);
constexpr auto kChair = static_cast<ClassId>(7);

LabelSet room_labels() { return {"room", {{kWall, "wall", false, {}}, {kChair, "chair", true, {}}}}; }

// Two pictures 5 x 1: void, chair (id 70000), two wall segments (1 and 256), and a kite, which the label set lacks (id 5).
Json coco_json() {
  return Json::parse(R"({
    "images": [{"id": 900, "file_name": "frame-000031.color.jpg", "width": 5, "height": 1},
               {"id": 17, "file_name": "frame-000008.color.jpg", "width": 5, "height": 1}],
    "annotations": [
      {"image_id": 17, "file_name": "b.png", "segments_info": []},
      {"image_id": 900, "file_name": "a.png", "segments_info": [
        {"id": 70000, "category_id": 62, "area": 1, "bbox": [1, 0, 1, 1], "iscrowd": 0, "score": 0.75},
        {"id": 256, "category_id": 199}, {"id": 1, "category_id": 199}, {"id": 5, "category_id": 38}]}],
    "categories": [{"id": 62, "name": "chair", "isthing": 1, "color": [1, 2, 3], "supercategory": "furniture"},
                   {"id": 199, "name": "wall", "isthing": 0}, {"id": 38, "name": "kite", "isthing": 1}]})");
}

Rgb color_of_id(unsigned id) {
  return {static_cast<std::uint8_t>(id % 256), static_cast<std::uint8_t>(id / 256 % 256), static_cast<std::uint8_t>(id / 65536)};
}

std::filesystem::path write_coco(const Json& json) {
  std::filesystem::path folder = fresh_folder();
  std::filesystem::create_directories(folder / "panoptic");
  write_json_file(folder / "panoptic.json", json);
  Image<Rgb> image(5, 1);
  const unsigned ids[] = {0, 70000, 1, 256, 5};
  for (std::size_t i = 0; i < 5; ++i) image[i] = color_of_id(ids[i]);
  write_png(folder / "panoptic" / "a.png", image);
  write_png(folder / "panoptic" / "b.png", Image<Rgb>(5, 1));
  return folder;
}

Frame frame_number(std::int64_t index) {
  Frame frame;
  frame.index = index;
  frame.color = Image<Rgb>(5, 1);
  return frame;
}

TEST(CocoPanoptic, IsMappedToTheLabelSetByName) {
  const std::filesystem::path folder = write_coco(coco_json());
  for (const auto& path : {folder, folder / "panoptic.json"}) {
    const auto predictor = make_file_predictor(path, room_labels());
    const Segmentation result = predictor->predict(frame_number(31));
    const auto segment = [&](int u) -> const Segment& { return result.segments.at(result.segment_at(u, 0) - 1U); };
    EXPECT_EQ(result.segments.size(), 2U);
    EXPECT_EQ(result.segment_at(0, 0), 0);
    EXPECT_EQ(segment(1).class_id, kChair);
    EXPECT_FLOAT_EQ(segment(1).score, 0.75F);
    EXPECT_EQ(segment(2).class_id, kWall);
    EXPECT_EQ(result.segment_at(2, 0), result.segment_at(3, 0));
    EXPECT_EQ(result.segment_at(4, 0), 0);
  }
}

TEST(CocoPanoptic, ReadsIdsFromGreyPictures) {
  Json json = coco_json();
  json["annotations"][1]["segments_info"][0]["id"] = 300;
  json["annotations"][1]["segments_info"][1]["id"] = 255;
  const std::filesystem::path folder = write_coco(json);
  write_png(folder / "panoptic" / "a.png", Image<std::uint16_t>(5, 1, std::vector<std::uint16_t>{0, 300, 1, 255, 5}));
  const auto predictor = make_file_predictor(folder, room_labels());
  const Segmentation wide = predictor->predict(frame_number(31));
  ASSERT_EQ(wide.segments.size(), 2U);
  EXPECT_NE(wide.segment_at[1], 0);
  EXPECT_NE(wide.segment_at[2], 0);
  EXPECT_EQ(wide.segment_at[2], wide.segment_at[3]);
  EXPECT_EQ(wide.segment_at[4], 0);
  const auto narrow = encode_png(Image<std::uint8_t>(5, 1, std::vector<std::uint8_t>{0, 0, 1, 255, 5}));
  write_file(folder / "panoptic" / "a.png", std::span<const std::uint8_t>(narrow));
  EXPECT_EQ(predictor->predict(frame_number(31)).segment_at[2], predictor->predict(frame_number(31)).segment_at[3]);
  EXPECT_NE(predictor->predict(frame_number(31)).segment_at[2], 0);
}

TEST(CocoPanoptic, KnowsSynonymsOfTheLabelSet) {
  Json json = coco_json();
  json["categories"][1]["name"] = "wall-other-merged";
  json["categories"][0]["name"] = "armchair";
  const Segmentation seen = make_file_predictor(write_coco(json), room_labels())->predict(frame_number(31));
  ASSERT_EQ(seen.segments.size(), 2U);
}

TEST(CocoPanoptic, ListsCategoriesThatTheLabelSetLacks) {
  const std::filesystem::path folder = write_coco(coco_json());
  EXPECT_THAT(make_file_predictor(folder, room_labels())->report().notes,
              testing::ElementsAre(testing::HasSubstr("kite (1 segments)")));
  EXPECT_TRUE(make_file_predictor(folder)->report().notes.empty());
}

// Three chairs side by side: one by itself, and two regions of chairs that nobody told apart.
TEST(CocoPanoptic, CrowdsOfAClassAreNoObject) {
  Json json = coco_json();
  json["annotations"][1]["segments_info"] = Json::parse(
      R"([{"id": 70000, "category_id": 62, "iscrowd": 1}, {"id": 256, "category_id": 62, "iscrowd": true},
          {"id": 1, "category_id": 62, "iscrowd": 0}, {"id": 5, "category_id": 199, "iscrowd": 1}])");
  const Segmentation result = make_file_predictor(write_coco(json), room_labels())->predict(frame_number(31));
  ASSERT_EQ(result.segments.size(), 3U);
  const auto segment = [&](int u) -> const Segment& { return result.segments.at(result.segment_at(u, 0) - 1U); };
  EXPECT_EQ(segment(1), (Segment{kChair, 1, {}, true}));
  EXPECT_EQ(result.segment_at(3, 0), result.segment_at(1, 0));
  EXPECT_EQ(segment(2), (Segment{kChair, 1, {}, false}));
  EXPECT_EQ(segment(4), (Segment{kWall, 1, {}, false})) << "stuff is never told apart";
}

TEST(CocoPanoptic, FindsFramesByTheNumberInTheFileName) {
  const auto predictor = make_file_predictor(write_coco(coco_json()), room_labels());
  EXPECT_TRUE(predictor->predict(frame_number(8)).segments.empty());
  EXPECT_FALSE(predictor->predict(frame_number(8)).segment_at.empty());
  EXPECT_TRUE(predictor->predict(frame_number(0)).segment_at.empty());
}

TEST(CocoPanoptic, CountsImagesWhereNamesHaveNoNumbersAndSaysSo) {
  Json json = coco_json();
  json["images"][0]["file_name"] = "kitchen.jpg";
  const auto predictor = make_file_predictor(write_coco(json), room_labels());
  EXPECT_EQ(predictor->predict(frame_number(0)).segments.size(), 2U);
  EXPECT_THAT(predictor->report().notes, Contains(HasSubstr("no numbers: they are taken for frames 0 to 1 in their order")));
  EXPECT_THAT(error_of([&] { predictor->predict(frame_number(31)); }), HasSubstr("no picture for frame 31"));
}

TEST(CocoPanoptic, FindsFramesByTheNamesOfPicturesWhereImagesHaveNoNumbers) {
  Json json = coco_json();
  for (Json& image : json["images"]) image["file_name"] = "kitchen.jpg";
  json["annotations"][0]["file_name"] = "frame-000006.png";
  json["annotations"][1]["file_name"] = "frame-000003.png";
  const std::filesystem::path folder = write_coco(json);
  std::filesystem::rename(folder / "panoptic/a.png", folder / "panoptic/frame-000003.png");
  std::filesystem::rename(folder / "panoptic/b.png", folder / "panoptic/frame-000006.png");
  const auto predictor = make_file_predictor(folder, room_labels());
  EXPECT_EQ(predictor->predict(frame_number(3)).segments.size(), 2U);
  EXPECT_TRUE(predictor->predict(frame_number(6)).segments.empty());
  EXPECT_TRUE(predictor->predict(frame_number(0)).segment_at.empty());
}

TEST(CocoPanoptic, BringsItsCategoriesAsLabelSet) {
  const auto predictor = make_file_predictor(write_coco(coco_json()));
  ASSERT_EQ(predictor->labels().classes().size(), 3U);
  EXPECT_TRUE(predictor->labels().is_stuff(static_cast<ClassId>(199)));
  EXPECT_EQ(predictor->labels().name_of(static_cast<ClassId>(38)), "kite");
  EXPECT_EQ(predictor->predict(frame_number(31)).segments.size(), 3U);
}

TEST(CocoPanoptic, RefusesALabelSetThatSharesNoNameWithTheCategories) {
  const LabelSet other("other", {{kWall, "hull", false, {}}, {kChair, "seat", true, {}}});
  const std::string message = error_of([&] { make_file_predictor(write_coco(coco_json()), other); });
  EXPECT_THAT(message, testing::AllOf(HasSubstr("panoptic.json"), HasSubstr("3 categories"), HasSubstr("'other'")));
}

TEST(CocoPanoptic, RefusesContradictions) {
  const auto refusal = [&](auto change) {
    Json bad = coco_json();
    change(bad);
    const std::filesystem::path folder = write_coco(bad);
    std::string message = error_of([&] { make_file_predictor(folder, room_labels())->predict(frame_number(31)); });
    EXPECT_THAT(message, HasSubstr(folder.string()));
    return message;
  };
  EXPECT_THAT(refusal([](Json& j) { j.erase("images"); }), HasSubstr("images"));
  EXPECT_THAT(refusal([](Json& j) { j["annotations"][1]["image_id"] = 18; }), HasSubstr("annotations[1].image_id"));
  EXPECT_THAT(refusal([](Json& j) { j["annotations"][1]["image_id"] = 17; }), HasSubstr("only annotation"));
  EXPECT_THAT(refusal([](Json& j) { j["annotations"][1]["segments_info"][0]["category_id"] = 63; }), HasSubstr("category_id"));
  EXPECT_THAT(refusal([](Json& j) { j["annotations"][1]["segments_info"][0]["id"] = 1; }), HasSubstr("two segments of id 1"));
  EXPECT_THAT(refusal([](Json& j) { j["annotations"][1]["segments_info"][0]["id"] = 1 << 24; }),
              HasSubstr("segments_info[0].id"));
  EXPECT_THAT(refusal([](Json& j) { j["annotations"][1]["segments_info"][0]["id"] = 70001; }), HasSubstr("id 70000"));
  EXPECT_THAT(refusal([](Json& j) { j["annotations"][1]["file_name"] = "absent.png"; }), HasSubstr("absent.png"));
  EXPECT_THAT(refusal([](Json& j) { j["categories"] = "all"; }), HasSubstr("categories"));
}

TEST(CocoPanoptic, RefusesADamagedPicture) {
  const std::filesystem::path folder = write_coco(coco_json());
  write_file(folder / "panoptic" / "a.png", std::string_view("not a picture"));
  const auto predictor = make_file_predictor(folder, room_labels());
  EXPECT_THAT(error_of([&] { predictor->predict(frame_number(31)); }), HasSubstr("a.png"));
}

}  // namespace
}  // namespace panoptic
