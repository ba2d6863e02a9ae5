// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// merge and diff, and map files in place of a run's folder and of online runs, from outside.
#include <signal.h>

#include <csignal>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/io/scannet_scan.h"
#include "panoptic/map_file.h"
#include "tests/apps/run_fixture.h"
#include "tests/viewer/browser.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::ProgramResult;
using test::run_program;
using test::RunningProgram;
using testing::HasSubstr;
namespace fs = std::filesystem;

class MapPairs : public test::Run {
 protected:
  MapPairs() : maps_(fresh_folder("maps")), predictions_(write_predictions()) {}

  // The map file of some of the frames.
  fs::path mapped(const std::string& name, const std::vector<std::string>& more = {}) const {
    const fs::path map = maps_ / (name + ".panoptic");
    std::vector<std::string> all{"--predictions", predictions_.string(), "--map", map.string()};
    all.insert(all.end(), more.begin(), more.end());
    const ProgramResult result = run(all);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return map;
  }
  static std::string hash_of(const fs::path& map) { return fmt::format("{:016x}", load_map(map).map.voxels.hash()); }

  fs::path maps_;
  fs::path predictions_;
};

TEST_F(MapPairs, TwoPartsOfARecordingAreMergedIntoOneMap) {
  const fs::path a = mapped("a", {"--frames", "0:7"});
  const fs::path b = mapped("b", {"--frames", "5:12"});
  const fs::path c = maps_ / "c.panoptic";
  const ProgramResult result = run_program({"merge", a.string(), b.string(), "-o", c.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("1 objects (1 and 1; 1 are the same"));
  const Json info = Json::parse(run_program({"info", c.string(), "--json"}).out);
  EXPECT_EQ(info["objects_by_class"]["chair"], 1);
  EXPECT_EQ(info["frames"]["used"], 14);
  EXPECT_THAT(info["recording"].get<std::string>(), HasSubstr(" + "));
  EXPECT_EQ(run_program({"mesh", c.string(), "-o", (maps_ / "c.ply").string()}).exit_code, 0);
  const ProgramResult regularized = run_program({"regularize", c.string()});
  EXPECT_EQ(regularized.exit_code, 0) << regularized.err;

  const ProgramResult again = run_program({"merge", a.string(), b.string(), "-o", c.string()});
  EXPECT_EQ(again.exit_code, 1);
  expect_one_line(again.err, "is there already");
  const ProgramResult resumed = run({"--predictions", predictions_.string(), "--map", c.string(), "--resume"});
  EXPECT_EQ(resumed.exit_code, 1);
  expect_one_line(resumed.err, "was merged from two maps");
  const fs::path coarse = mapped("coarse", {"--set", "map.voxel_size_m=0.1"});
  const ProgramResult other = run_program({"merge", a.string(), coarse.string(), "-o", (maps_ / "d.panoptic").string()});
  EXPECT_EQ(other.exit_code, 1);
  expect_one_line(other.err, "voxels of");
  EXPECT_FALSE(fs::exists(maps_ / "d.panoptic"));
}

TEST_F(MapPairs, DiffSaysWhatChangedAsTextJsonAndPicture) {
  const fs::path a = mapped("a");
  const fs::path json = maps_ / "diff.json";
  const fs::path png = maps_ / "diff.png";
  const ProgramResult same = run_program({"diff", a.string(), a.string(), "--json", json.string()});
  ASSERT_EQ(same.exit_code, 0) << same.err;
  EXPECT_THAT(same.out, testing::StartsWith("1 objects are where they were, 0 changes\n"));
  EXPECT_THAT(same.out, HasSubstr("of B's surface is in A, too; there they lie 0.0 cm apart (median; 95 %: 0.0 cm)\n"));
  EXPECT_EQ(read_json_file(json)["surfaces"]["apart_median_m"], 0.0);
  EXPECT_EQ(read_json_file(json)["unchanged"], 1);
  EXPECT_TRUE(read_json_file(json)["changes"].empty());
  EXPECT_FALSE(fs::exists(png)) << "nobody asked for a picture";

  // A map in which the ball was never labelled.
  fs::remove_all(predictions_);
  const fs::path without = maps_ / "without.panoptic";
  ASSERT_EQ(run({"--map", without.string()}).exit_code, 0);
  const ProgramResult changed =
      run_program({"diff", a.string(), without.string(), "--json", json.string(), "--png", png.string()});
  ASSERT_EQ(changed.exit_code, 0) << changed.err;
  EXPECT_THAT(changed.out, HasSubstr("other label    chair"));
  EXPECT_EQ(read_rgb(png).width(), 2560);
  const Json changes = read_json_file(json)["changes"];
  const auto chair = std::find_if(changes.begin(), changes.end(), [](const Json& c) { return !c["before"].is_null(); });
  ASSERT_NE(chair, changes.end());
  EXPECT_EQ((*chair)["kind"], "other_label");
  EXPECT_EQ((*chair)["before"]["class"], "chair");
  EXPECT_TRUE((*chair)["after"].is_null()) << "without a prediction nothing has a name";
  EXPECT_EQ(run_program({"diff", a.string()}).exit_code, 2);
  expect_one_line(run_program({"diff", a.string(), recording_.string()}).err, "recording");
}

TEST_F(MapPairs, EvalScoresAMapFileAsTheFolderOfItsRun) {
  const fs::path map = mapped("a", {"--set", "map.voxel_size_m=0.024"});
  const fs::path scan = fresh_folder("scan");
  ScanTruth truth;
  truth.scene = "scene0001_00";
  for (int i = 0; i < 400; ++i) {  // points on the upper half of the ball
    const double height = i / 400.0;
    const double angle = 2.4 * i;
    const double around = std::sqrt(1 - height * height);
    truth.positions.push_back((0.6 * Vec3d(around * std::cos(angle), -height, around * std::sin(angle))).cast<float>());
    truth.class_id.push_back(ClassId{5});
    truth.instance.push_back(1);
  }
  for (std::uint32_t i = 0; i + 2 < 400; ++i) truth.triangles.push_back({i, i + 1, i + 2});
  truth.colors.resize(400);
  write_scan_truth(scan, truth);
  const auto scores = [&](const fs::path& of) {
    const fs::path json = maps_ / "scores.json";
    const ProgramResult result = run_program({"eval", of.string(), "--gt", scan.string(), "--json", json.string()});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    Json all = read_json_file(json);
    all.erase("settings");
    return all;
  };
  const Json of_map = scores(map);
  EXPECT_GT(of_map["coverage"].get<double>(), 0.5);
  EXPECT_EQ(of_map, scores(out_));
}

TEST_F(MapPairs, ViewShowsAMapFileWithItsConfidence) {
  const fs::path map = mapped("kitchen");
  const ProgramResult result = run_program({"view", map.string(), "--port", "0"}, {}, [&](const RunningProgram& program) {
    EXPECT_TRUE(test::wait_for_text(program, program.out, "Ctrl-C"));
    const std::string text = read_file(program.out);
    const auto port = static_cast<std::uint16_t>(std::stoi(text.substr(text.find("http://127.0.0.1:") + 17)));
    const Json scene = Json::parse(test::fetch(port, "/api/scene").body);
    EXPECT_EQ(scene["title"], "kitchen");
    EXPECT_EQ(scene["has_confidence"], true);
    const Json state = Json::parse(test::fetch(port, "/api/state").body);
    EXPECT_EQ(state["run"]["frames_used"], 12);
    EXPECT_EQ(state["run"]["finished"], true);
    EXPECT_EQ(state["path"].size(), 12U);
    EXPECT_FALSE(state["chunks"].empty());
    EXPECT_EQ(Json::parse(test::fetch(port, "/api/objects").body)["objects"].size(), 1U);
    ::kill(program.pid, SIGINT);
  });
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  write_file(maps_ / "no.panoptic", std::string(5000, 'x'));
  for (const char* command : {"view", "eval"}) {
    std::vector<std::string> arguments{command, (maps_ / "no.panoptic").string()};
    if (arguments[0] == "eval") arguments.insert(arguments.end(), {"--gt", recording_.string()});
    const ProgramResult refused = run_program(arguments);
    EXPECT_EQ(refused.exit_code, 1);
    expect_one_line(refused.err, "no.panoptic");
  }
}

TEST_F(MapPairs, AnOnlineRunKeepsAMapFileThatHoldsItsMap) {
  const fs::path map = mapped("online", {"--online", "--speed", "max", "--checkpoint-every", "0"});
  EXPECT_EQ(hash_of(map), report()["map_hash"]);
  EXPECT_EQ(load_frames(map).size(), 12U);
  EXPECT_EQ(std::distance(fs::directory_iterator(maps_), fs::directory_iterator()), 1) << "one file";
  const auto resume = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--predictions", predictions_.string(), "--map", map.string(), "--resume"});
    return run(more);
  };
  EXPECT_EQ(resume({"--online"}).exit_code, 2);
  const ProgramResult offline = resume({});
  EXPECT_EQ(offline.exit_code, 1);
  expect_one_line(offline.err, "an online run cannot be resumed");
}

TEST_F(MapPairs, AnOnlineRunThatIsKilledLeavesASoundMap) {
  const fs::path map = maps_ / "killed.panoptic";
  const ProgramResult result =
      run_program({"run", "--no-pictures", recording_.string(), "-o", out_.string(), "--predictions", predictions_.string(),
                   kCoarse[0], kCoarse[1], "--map", map.string(), "--online", "--speed", "0.5", "--checkpoint-every", "0"},
                  {}, [&](const RunningProgram& program) {
                    test::wait_for_text(program, program.out, "labels");
                    for (int i = 0; i < 200 && (!fs::exists(map) || load_frames(map).size() < 3); ++i) usleep(20000);
                    ::kill(program.pid, SIGKILL);
                  });
  ASSERT_EQ(result.exit_code, 128 + SIGKILL);
  const SavedMap saved = load_map(map);
  EXPECT_GT(saved.map.voxels.block_count(), 0U);
  const std::size_t frames = load_frames(map).size();
  EXPECT_GE(frames, 3U);
  EXPECT_LT(frames, 12U);
}

}  // namespace
}  // namespace panoptic
