// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/scene_history.h"

#include <fmt/format.h>

#include "apps/viewer/assets.h"
#include "apps/viewer/saved_page.h"
#include "panoptic/base/files.h"
#include "panoptic/mapfile/run_notes.h"
#include "tests/fresh_folder.h"
#include "tests/io/run_json.h"
#include "tests/viewer/server_fixture.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

Json with_times(Json object, double first_s, const Json& gone_s) {
  object["first_time"] = first_s;
  object["last_time"] = 20;
  object["gone_time"] = gone_s;
  for (const char* key : {"moved_from", "moved_to"}) object[key] = nullptr;
  object["appeared"] = false;
  return object;
}

Json box_json(std::int64_t frame, double time_s) {
  return {{"frame", frame}, {"time_s", time_s}, {"box", {{"min_m", {0, 0, time_s}}, {"max_m", {1, 2, time_s + 1}}}}};
}

class RunHistory : public testing::Test {
 protected:
  RunHistory() : folder_(test::fresh_folder("home")) {
    Json moved = with_times(test::object_json(9, "swivel chair"), 0.5, 12.5);
    moved["moved_to"] = 11;
    Json chair = with_times(test::object_json(11, "swivel chair"), 13, nullptr);
    chair["appeared"] = true;
    chair["moved_from"] = 9;
    objects_ = {{"objects", {chair, moved}}};
    moving_ = {{"tracks", {{{"id", 4}, {"class", nullptr}, {"frames", {box_json(3, 1), box_json(5, 2)}}}}},
               {"forgotten_boxes", 7}};
    write();
  }
  void write() const {
    write_json_file(folder_ / "objects.json", objects_);
    write_json_file(folder_ / "moving.json", moving_);
  }
  SceneHistory read() const { return read_run_history(folder_, test::small_labels()); }
  std::string refusal() const {
    write();
    return error_of([&] { (void)read(); });
  }

  fs::path folder_;
  Json objects_;
  Json moving_;
};

TEST_F(RunHistory, IsWhatTheRunWrote) {
  const SceneHistory history = read();
  EXPECT_FALSE(history.is_still());
  EXPECT_EQ(history.start_s, 0.5);
  EXPECT_EQ(history.end_s, 20);
  ASSERT_EQ(history.spans.size(), 2U);
  EXPECT_EQ(history.spans[0].gone_s, 12.5);
  EXPECT_EQ(history.spans[0].moved_to, PanopticId{11});
  EXPECT_EQ(history.spans[1].moved_from, PanopticId{9});
  EXPECT_TRUE(history.spans[1].appeared);
  EXPECT_EQ(history.spans[1].box.max_m, Vec3d(1, 2, 3));
  ASSERT_EQ(history.tracks.size(), 1U);
  EXPECT_EQ(history.tracks[0].class_id, ClassId::kUnknown);
  EXPECT_EQ(history.tracks[0].boxes[1], (TrackedBox{5, 2, Vec3d(0, 0, 2), Vec3d(1, 2, 3)}));
  EXPECT_EQ(history.forgotten_boxes, 7U);
}

TEST_F(RunHistory, NothingChangesWhereEverythingWasThereFromTheBeginning) {
  fs::remove(folder_ / "moving.json");
  objects_["objects"] = Json::array({with_times(test::object_json(9, "swivel chair"), 0, nullptr)});
  write_json_file(folder_ / "objects.json", objects_);
  EXPECT_TRUE(read().is_still());
  objects_["objects"] = Json::array({test::object_json(9, "swivel chair")});  // as an early version wrote it
  write_json_file(folder_ / "objects.json", objects_);
  EXPECT_TRUE(read().is_still());
  EXPECT_TRUE(read().spans.empty());
}

TEST_F(RunHistory, WhatIsWrongIsNamedWithItsFile) {
  moving_["tracks"][0]["class"] = "spaceship";
  EXPECT_THAT(refusal(), AllOf(HasSubstr("moving.json"), HasSubstr("a class of report.json")));
  moving_["tracks"][0]["class"] = "swivel chair";
  moving_["tracks"][0]["frames"] = {box_json(5, 2), box_json(3, 1)};
  EXPECT_THAT(refusal(), AllOf(HasSubstr("moving.json"), HasSubstr("later than the one before it")));
  moving_["tracks"][0]["frames"] = Json::array();
  EXPECT_THAT(refusal(), HasSubstr("a frame and more"));
  moving_["tracks"] = Json::array();
  objects_["objects"][0]["gone_time"] = "soon";
  EXPECT_THAT(refusal(), HasSubstr("objects.json"));
}

TEST(MapHistory, IsWhatTheFileKeeps) {
  SavedMap saved{MapOptions{}, PanopticMap(MapOptions{}, test::small_labels()), {}};
  PastObject past{.id = PanopticId{9}, .class_id = ClassId{2}, .first_frame = 10, .last_frame = 12, .gone_frame = 20};
  past.box = {Vec3d(0, 0, 0), Vec3d(1, 2, 3), Vec3d(0.5, 1, 1.5)};
  saved.map.history.past.push_back(past);
  const std::vector<FrameRecord> frames = {{.frame = 5, .time_s = 1}, {.frame = 10, .time_s = 2}, {.frame = 20, .time_s = 4}};
  EXPECT_TRUE(history_of(saved, frames).tracks.empty()) << "no run made it";
  SavedState state;
  MovingTrack walk{.id = 3, .class_id = ClassId{2}, .boxes = {}};
  for (const double time_s : {2.0, 3.0, 4.0}) walk.boxes.push_back({10, time_s, Vec3d::Zero(), Vec3d::Ones()});
  state.moving.followed.push_back({walk, {{ClassId{2}, 3}}});
  state.moving.next_id = 4;
  state.moving.forgotten = 6;
  saved.notes = notes_of(state);
  const SceneHistory history = history_of(saved, frames);
  EXPECT_EQ(history.start_s, 1);
  EXPECT_EQ(history.end_s, 4);
  ASSERT_EQ(history.spans.size(), 1U);
  EXPECT_EQ(history.spans[0].first_s, 2);
  EXPECT_EQ(history.spans[0].gone_s, 4);
  EXPECT_EQ(history.tracks, std::vector<MovingTrack>{walk});
  EXPECT_EQ(history.forgotten_boxes, 6U);
}

class ServedHistory : public test::Served {
 protected:
  Json served(SceneHistory history) {
    server_ = std::make_unique<ViewerServer>(ViewerOptions{.port = 0}, world_.scene(), latest_, PlaySource("", kNoPlay), history);
    port_ = test::port_of(*server_);
    EXPECT_EQ(json("/api/scene")["has_history"], !history.is_still());
    return json("/api/history");
  }
  static MovingTrack track(std::uint32_t id, std::size_t boxes) {
    MovingTrack track{.id = id, .class_id = ClassId{2}, .boxes = {}};
    for (std::size_t i = 0; i < boxes; ++i) {
      const auto number = static_cast<double>(i);
      track.boxes.push_back({static_cast<std::int64_t>(i), number / 4, Vec3d(number, 0, 0), Vec3d(number + 1, 2, 1)});
    }
    return track;
  }
};

TEST_F(ServedHistory, ARunThatGoesOnHasNone) {
  EXPECT_EQ(json("/api/scene")["has_history"], false);
  EXPECT_TRUE(json("/api/history")["objects"].empty());
}

TEST_F(ServedHistory, SaysWhenObjectsWereThereAndWhereThingsMoved) {
  ObjectSpan gone{.id = PanopticId{9}, .class_id = ClassId{2}, .first_s = 1, .gone_s = 2.5};
  gone.box = {Vec3d(0, 0, 0), Vec3d(1, 2, 3), Vec3d(0.5, 1, 1.5)};
  gone.moved_to = test::kBallId;
  const Json history = served({0, 8, {gone}, {track(3, 5)}, 2});
  EXPECT_EQ(history["start_s"], 0);
  EXPECT_EQ(history["end_s"], 8);
  const Json& object = history["objects"][0];
  EXPECT_EQ(object["first_s"], 1);
  EXPECT_EQ(object["gone_s"], 2.5);
  EXPECT_EQ(object["max_m"], (Json{1, 2, 3}));
  EXPECT_EQ(object["moved_to"], number(test::kBallId));
  EXPECT_EQ(object["moved_from"], nullptr);
  const Json& boxes = history["tracks"][0]["boxes"];
  ASSERT_EQ(boxes.size(), 35U);
  EXPECT_EQ(Json(std::vector<Json>(boxes.begin() + 7, boxes.begin() + 14)), (Json{0.25, 1, 0, 0, 2, 2, 1}));
  EXPECT_EQ(history["left_out"], (Json{{"objects", 0}, {"tracks", 0}, {"boxes", 0}, {"forgotten_boxes", 2}}));
}

TEST_F(ServedHistory, MoreThanAPageTakesIsThinnedAndCounted) {
  SceneHistory history{.end_s = 1e4};
  history.tracks = {track(1, 30000), track(2, 9)};
  for (std::uint32_t id = 3; id < 1010; ++id) history.tracks.push_back(track(id, 3));
  const Json sent = served(history);
  ASSERT_EQ(sent["tracks"].size(), 1000U);
  std::size_t boxes = 0;
  for (const Json& one : sent["tracks"]) boxes += one["boxes"].size() / 7;
  EXPECT_LE(boxes, 20000U);
  EXPECT_GT(boxes, 10000U);
  EXPECT_EQ(sent["left_out"]["tracks"], 9);
  EXPECT_EQ(sent["left_out"]["boxes"], 30000 + 9 + 998 * 3 - boxes);
  const Json& longest = sent["tracks"][0]["boxes"];
  EXPECT_EQ(longest[0], 0);
  EXPECT_EQ(longest[longest.size() - 7], 29999.0 / 4) << "its last place";
}

TEST_F(ServedHistory, ASavedPageKeepsIt) {
  if (web_assets().empty()) GTEST_SKIP() << "the page was not built";
  const fs::path folder = test::fresh_folder("page");
  save_page(folder, {world_.scene(), world_.snapshot(), {0, 8, {}, {track(3, 5)}, 0}}, PlaySource("", kNoPlay), 0);
  EXPECT_THAT(read_file(folder / "data" / "map.js"), HasSubstr("\"/api/history\""));
}

}  // namespace
}  // namespace panoptic
