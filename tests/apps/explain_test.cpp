// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic explain` from outside: the ball of the orbit recording is a chair.
#include <algorithm>
#include <cmath>
#include <map>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "tests/apps/run_fixture.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::ProgramResult;
using test::run_program;
using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

class Explain : public test::Run {
 protected:
  Explain() {
    const ProgramResult result = run({"--predictions", write_predictions().string()});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const Json file = read_json_file(out_ / "objects.json");
    for (const Json& object : file["objects"]) {
      if (object["class"] == "chair") chair_ = object;
    }
  }
  ProgramResult explain(const std::string& id, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"explain", out_.string(), id};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  std::string chair_id() const { return std::to_string(chair_["id"].get<int>()); }

  Json chair_;
};

// The mask of the ball in a frame, as write_predictions makes it.
std::vector<int> true_box(int index) {
  const Frame frame = test::orbit_frame(index);
  std::vector<int> box = {1000, 1000, 0, 0};
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      if (p.y() <= 0.599) box = {std::min(box[0], u), std::min(box[1], v), std::max(box[2], u + 1), std::max(box[3], v + 1)};
    }
  }
  return box;
}

TEST_F(Explain, TheRunWritesDownVotesAndBestFramesOfTheBall) {
  std::uint64_t votes = 0;
  for (const Json& bin : chair_["votes"]["bins"]) votes += bin["classes"]["chair"].get<std::uint64_t>();
  EXPECT_EQ(votes, chair_["observations"].get<std::uint64_t>());
  ASSERT_EQ(chair_["best_views"].size(), 3U);
  for (const Json& view : chair_["best_views"]) {
    EXPECT_EQ(view["box_px"].get<std::vector<int>>(), true_box(view["frame"].get<int>()));
    EXPECT_FLOAT_EQ(view["score"].get<float>(), 0.8F);
  }
}

TEST_F(Explain, SaysWhyTheBallIsAChair) {
  const ProgramResult result = explain(chair_id());
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, AllOf(HasSubstr("chair " + chair_id() + "\n"), HasSubstr("probabilities  chair 1.000"),
                                HasSubstr("frames 0 to 11, 12 observations"), HasSubstr("best frames")));
}

TEST_F(Explain, ThePictureShowsTheFramesAndTheObjectInTheMap) {
  const fs::path png = fresh_folder("sheet") / "chair.png";
  const ProgramResult result = explain(chair_id(), {"--png", png.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Image<Rgb> sheet = read_rgb(png);
  ASSERT_TRUE(sheet.same_size(1280, 960));
  // Pixels of the strongest orange: boxes around the ball in each of the three tiles; an orange ball in both renders.
  std::map<std::string, int> orange;
  for (int v = 0; v < sheet.height(); ++v) {
    for (int u = 0; u < sheet.width(); ++u) {
      const Rgb c = sheet(u, v);
      if (c.r < c.b + 40) continue;
      if (v < 352 && c == Rgb{235, 95, 10}) ++orange["tile " + std::to_string((u - 16) / 421)];
      if (v >= 520) ++orange[u < 640 ? "front" : "top"];
    }
  }
  for (const char* place : {"tile 0", "tile 1", "tile 2"}) EXPECT_GT(orange[place], 300) << place;
  for (const char* place : {"front", "top"}) EXPECT_GT(orange[place], 5000) << place;
}

TEST_F(Explain, WithoutItsRecordingTheWordsStandAndThePictureIsAnError) {
  fs::rename(recording_, recording_.string() + "_elsewhere");
  const fs::path png = fresh_folder("sheet") / "chair.png";
  const ProgramResult result = explain(chair_id(), {"--png", png.string()});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "cannot be opened any more");
  EXPECT_THAT(result.out, HasSubstr("chair " + chair_id()));
  EXPECT_FALSE(fs::exists(png));
}

TEST_F(Explain, AnotherRecordingUnderTheSameNameIsRefused) {
  fs::remove_all(recording_);
  test::write_orbit_recording(recording_, 5);
  const ProgramResult result = explain(chair_id(), {"--png", (fresh_folder("sheet") / "chair.png").string()});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "is another recording by now");
}

TEST_F(Explain, AnUnreadableFrameLeavesTheOthers) {
  const int best = chair_["best_views"][0]["frame"].get<int>();
  write_file(file(best, "pose.txt"), "nan 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  const fs::path png = fresh_folder("sheet") / "chair.png";
  const ProgramResult result = explain(chair_id(), {"--png", png.string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(png));
}

TEST_F(Explain, UnknownIdsAndFoldersAreOneLine) {
  const ProgramResult id = explain("9999");
  EXPECT_EQ(id.exit_code, 1);
  expect_one_line(id.err, "no object has the id 9999");
  const ProgramResult folder = run_program({"explain", recording_.string(), "1"});
  EXPECT_EQ(folder.exit_code, 1);
  expect_one_line(folder.err, "no objects.json");
  expect_one_line(explain("3000000003").err, "no object has the id 3000000003");
  for (const char* no_id : {"chair", "-1", "4294967296"}) EXPECT_EQ(explain(no_id).exit_code, 2) << no_id;
}

}  // namespace
}  // namespace panoptic
