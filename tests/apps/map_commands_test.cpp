// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run --map` and what can be done with the file, from outside; and what is left of it when the process is killed.
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <random>

#include "panoptic/base/files.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/map_file.h"
#include "panoptic/mapfile/log_rows.h"
#include "panoptic/profile.h"
#include "tests/apps/run_fixture.h"
#include "tests/fresh_seed.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;
namespace fs = std::filesystem;

// A run with labels, of which a map is kept in map().
class Map : public test::Run {
 protected:
  Map() : predictions_(write_predictions()), map_(fresh_folder("map") / "map.panoptic") {}

  std::vector<std::string> arguments(std::vector<std::string> more = {}) const {
    std::vector<std::string> all{"run",
                                 "--no-pictures",
                                 recording_.string(),
                                 "-o",
                                 out_.string(),
                                 "--predictions",
                                 predictions_.string(),
                                 kCoarse[0],
                                 kCoarse[1],
                                 "--set",
                                 "objects.every_frames=3",
                                 "--set",
                                 "regularizer.every_frames=5",
                                 "--map",
                                 map_.string()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  ProgramResult run_with_map(const std::vector<std::string>& more = {}) const { return run_program(arguments(more)); }
  // The hash of a run that nothing disturbed.
  std::string expected_hash() const {
    const fs::path out = fresh_folder("undisturbed");
    const ProgramResult result =
        run_program({"run", "--no-pictures", recording_.string(), "-o", out.string(), "--predictions", predictions_.string(),
                     kCoarse[0], kCoarse[1], "--set", "objects.every_frames=3", "--set", "regularizer.every_frames=5"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_json_file(out / "report.json")["map_hash"];
  }
  std::string hash_of_map() const { return fmt::format("{:016x}", load_map(map_).map.voxels.hash()); }

  fs::path predictions_;
  fs::path map_;
};

TEST_F(Map, HoldsWhatTheRunMappedInOneFile) {
  const ProgramResult result = run_with_map();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(hash_of_map(), report()["map_hash"]);
  EXPECT_EQ(hash_of_map(), expected_hash());
  EXPECT_EQ(std::distance(fs::directory_iterator(map_.parent_path()), fs::directory_iterator()), 1);
  EXPECT_EQ(load_frames(map_).size(), 12U);
  Database database(map_, DatabaseAccess::kRead);
  EXPECT_EQ(database.integer("SELECT objects FROM class_summary WHERE class = 'chair'"), 1);
}

TEST_F(Map, IsNotOverwrittenAndGoesOnOnlyWhenAsked) {
  ASSERT_EQ(run_with_map().exit_code, 0);
  const ProgramResult again = run_with_map();
  EXPECT_EQ(again.exit_code, 1);
  expect_one_line(again.err, "--resume");
  const ProgramResult resumed = run_with_map({"--resume"});
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_THAT(resumed.out, HasSubstr("nothing is left to map"));
  EXPECT_EQ(report()["map_hash"], hash_of_map());
  const ProgramResult other = run_with_map({"--resume", "--set", "map.voxel_size_m=0.05"});
  EXPECT_EQ(other.exit_code, 1);
  expect_one_line(other.err, "of another run");
}

TEST_F(Map, AnInterruptedRunGoesOnToTheSameResult) {
  const ProgramResult interrupted = run_program(arguments(), {}, [](const test::RunningProgram& program) {
    test::wait_for_text(program, program.out, "labels");
    kill(program.pid, SIGINT);
  });
  if (interrupted.exit_code == 130) {
    EXPECT_LT(load_frames(map_).size(), 12U);
  }
  const ProgramResult resumed = run_with_map({"--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(hash_of_map(), expected_hash());
  EXPECT_EQ(report()["frames"]["used"], 12);
}

TEST_F(Map, ADiskThatIsFullDuringTheRunIsSaidOnceAndAtTheEnd) {
  const auto limit = [] {
    const rlimit bytes{90000, 90000};
    setrlimit(RLIMIT_FSIZE, &bytes);
    std::signal(SIGXFSZ, SIG_IGN);
  };
  const ProgramResult result = run_program(arguments({"--checkpoint-every", "0"}), limit);
  EXPECT_EQ(result.exit_code, 1);
  const auto all = test::lines(result.err);
  const auto warns = [](const std::string& line) { return line.find("not saved for now") != std::string::npos; };
  EXPECT_LE(std::count_if(all.begin(), all.end(), warns), 1) << result.err;
  expect_one_line(result.err, "map.panoptic");
  EXPECT_LT(load_frames(map_).size(), 12U) << "an earlier checkpoint is still there";
  ASSERT_EQ(run_with_map({"--resume"}).exit_code, 0);
  EXPECT_EQ(hash_of_map(), expected_hash());
}

// Copies of the frames are what fills it.
TEST_F(Map, ADiskThatIsFullOfCopiesLeavesTheLastSavedState) {
  const auto limit = [] {
    const rlimit bytes{600'000, 600'000};
    setrlimit(RLIMIT_FSIZE, &bytes);
    std::signal(SIGXFSZ, SIG_IGN);
  };
  const ProgramResult result = run_program(arguments({"--checkpoint-every", "0", "--set", "map.log=copy"}), limit);
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "map.panoptic");
  const std::size_t frames = load_frames(map_).size();
  EXPECT_LT(frames, 12U) << "an earlier checkpoint is still there";
  EXPECT_EQ(size_of_log(map_).copies, frames);
  ASSERT_EQ(run_with_map({"--resume", "--set", "map.log=copy"}).exit_code, 0);
  EXPECT_EQ(hash_of_map(), expected_hash());
  EXPECT_EQ(size_of_log(map_).copies, 12U);
}

TEST_F(Map, AnswersTheCommandsThatLookAtIt) {
  ASSERT_EQ(run_with_map().exit_code, 0);
  const ProgramResult info = run_program({"info", map_.string(), "--json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const Json json = Json::parse(info.out);
  EXPECT_EQ(json["map_hash"], report()["map_hash"]);
  EXPECT_EQ(json["frames"]["used"], 12);
  EXPECT_EQ(json["log"]["frames"], 12);
  EXPECT_EQ(json["complete"], true);
  EXPECT_EQ(json["objects_by_class"]["chair"], 1);
  EXPECT_THAT(run_program({"info", map_.string()}).out, HasSubstr("1 x chair"));

  const fs::path ply = map_.parent_path() / "mesh.ply";
  ASSERT_EQ(run_program({"mesh", map_.string(), "-o", ply.string()}).exit_code, 0);
  EXPECT_TRUE(read_file(ply) == read_file(out_ / "mesh.ply")) << "as the run wrote it";
  const fs::path glb = map_.parent_path() / "scene.glb";
  ASSERT_EQ(run_program({"mesh", map_.string(), "-o", glb.string()}).exit_code, 0);
  EXPECT_TRUE(read_file(glb) == read_file(out_ / "scene.glb")) << "as the run wrote it";
  EXPECT_EQ(run_program({"mesh", map_.string(), "-o", "mesh.stl"}).exit_code, 2);
}

TEST_F(Map, AnswersQuestions) {
  ASSERT_EQ(run_with_map().exit_code, 0);
  const auto ask = [&](const std::vector<std::string>& question) {
    std::vector<std::string> all{"query", map_.string(), "--json"};
    all.insert(all.end(), question.begin(), question.end());
    const ProgramResult result = run_program(all);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(result.out);
  };
  const Json chairs = ask({"--class", "chair"});
  ASSERT_EQ(chairs.size(), 1U);
  const int id = chairs[0]["id"];
  EXPECT_NEAR(chairs[0]["center_m"][1].get<double>(), 0, 0.6);
  EXPECT_EQ(ask({"--class", "tv"}).size(), 0U);
  EXPECT_EQ(ask({"--box=-0.1,-0.7,-0.1,0.1,0.1,0.1"}).size(), 1U);
  EXPECT_EQ(ask({"--box", "10,10,10,11,11,11"}).size(), 0U);
  const Json near = ask({"--nearest=0,-1,0"});
  EXPECT_EQ(near[0]["id"], id);
  EXPECT_NEAR(near[0]["distance_m"].get<double>(), 0.4, 0.05) << "the ball has a radius of 0.6";
  const Json at = ask({"--at=0.5,-0.23,0.24"});  // where the camera faces the ball
  EXPECT_EQ(at["id"], id);
  EXPECT_EQ(at["class"], "chair");
  EXPECT_NEAR(at["distance_m"].get<double>(), 0, 0.03);
  EXPECT_TRUE(ask({"--at=0,-5,0"}).is_null());
  EXPECT_EQ(run_program({"query", map_.string(), "--at", "1,2"}).exit_code, 2);
  EXPECT_EQ(run_program({"query", map_.string(), "--at", "1,2,3,"}).exit_code, 2);
  EXPECT_EQ(run_program({"query", map_.string(), "--at", "1,2,3", "--class", "tv"}).exit_code, 2);
  expect_one_line(run_program({"query", map_.string(), "--class", "dragon"}).err, "no class 'dragon'");
}

TEST_F(Map, IsRegularizedInPlace) {
  ASSERT_EQ(run_with_map({"--set", "regularizer.enabled=false"}).exit_code, 0);
  const std::string before = hash_of_map();
  const ProgramResult result = run_program({"regularize", map_.string(), "--set", "regularizer.w2=20"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(hash_of_map(), before);
  const std::string once = hash_of_map();
  ASSERT_EQ(run_program({"regularize", map_.string(), "--set", "regularizer.w2=20"}).exit_code, 0);
  EXPECT_EQ(hash_of_map(), once) << "it works from what the frames voted for, not from what it wrote itself";
}

TEST_F(Map, OfAnOlderFormatIsReadWithALineAboutWhatItLacksAndSavedAnewByRegularize) {
  fs::copy_file(test::source_folder() / "tests/golden/format_1.panoptic", map_);
  const auto told = [&](const ProgramResult& result) {
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, testing::AllOf(testing::StartsWith("note: "), HasSubstr("format 1, which lacks the sum of votes")));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  told(run_program({"info", map_.string()}));
  told(run_program({"query", map_.string()}));
  told(run_program({"mesh", map_.string(), "-o", (map_.parent_path() / "mesh.ply").string()}));
  told(run_program({"regularize", map_.string()}));
  EXPECT_EQ(load_map(map_).format, kMapFormat);
  EXPECT_EQ(load_frames(map_).size(), 12U);
  EXPECT_EQ(run_program({"info", map_.string()}).err, "");
  const ProgramResult resumed = run_with_map({"--resume"});
  EXPECT_EQ(resumed.exit_code, 1);
  expect_one_line(resumed.err, "was made in format 1");
}

TEST_F(Map, ThatIsNoMapIsSaidInOneLine) {
  write_file(map_, std::string(5000, 'x'));
  for (const char* command : {"info", "query", "regularize"}) {
    const ProgramResult result = run_program({command, map_.string()});
    EXPECT_EQ(result.exit_code, 1);
    expect_one_line(result.err, "map.panoptic");
  }
}

// Whatever the moment, what is there is a sound map, and resuming comes to the same end. Named so that CMake can label it slow.
TEST_F(Map, SlowSurvivesBeingKilledAtAnyMoment) {
  const std::string expected = expected_hash();
  const Stopwatch stopwatch;
  const std::vector<std::string> copying = {"--checkpoint-every", "0", "--set", "map.log=copy"};
  ASSERT_EQ(run_with_map(copying).exit_code, 0);
  const auto whole_us = static_cast<useconds_t>(1e6 * stopwatch.seconds());
  constexpr int kMoments = 20;
  std::mt19937 random(test::fresh_seed());
  int killed = 0;
  for (int i = 0; i < kMoments; ++i) {
    fs::remove_all(map_.parent_path());
    fs::create_directories(map_.parent_path());
    const ProgramResult result = run_program(arguments(copying), {}, [&](const test::RunningProgram& program) {
      test::wait_for_text(program, program.out, "labels");
      usleep(static_cast<useconds_t>(random() % (whole_us / 2)));
      kill(program.pid, SIGKILL);
    });
    killed += result.exit_code == 128 + SIGKILL ? 1 : 0;
    if (fs::exists(map_)) {
      Database database(map_, DatabaseAccess::kWrite);
      EXPECT_EQ(database.text("PRAGMA integrity_check"), "ok");
      load_map(map_);
      EXPECT_EQ(size_of_log(map_).copies, load_frames(map_).size()) << "all of a checkpoint, or nothing";
    }
    const ProgramResult resumed = run_with_map({"--resume", "--set", "map.log=copy"});
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    ASSERT_EQ(hash_of_map(), expected) << "killed at moment " << i;
    ASSERT_EQ(size_of_log(map_).copies, 12U);
  }
  EXPECT_GT(killed, kMoments / 2) << "most runs were killed before they ended";
}

}  // namespace
}  // namespace panoptic
