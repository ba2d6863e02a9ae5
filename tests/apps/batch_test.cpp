// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// panoptic batch: every scene once, whatever happens.
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <random>
#include <thread>

#include "panoptic/base/files.h"
#include "panoptic/profile.h"
#include "tests/apps/run_fixture.h"
#include "tests/fresh_seed.h"
#include "tests/predict/tiny_onnx.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;
namespace fs = std::filesystem;
using Words = std::vector<std::string>;

class Batch : public test::Run {
 protected:
  Batch() : scenes_(fresh_folder("scenes")), output_(fresh_folder("outs") / "out") {
    for (const auto& [name, frames] : kScenes) test::write_orbit_recording(scenes_ / name, frames);
  }

  Words batch(const fs::path& out, const Words& own = {}, const Words& more = {}) const {
    Words words{"batch", scenes_.string(), "-o", out.string()};
    words.insert(words.end(), own.begin(), own.end());
    words.insert(words.end(), {"--", "--no-pictures", "--set", "map.voxel_size_m=0.08", "--threads", "1"});
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  static Json report_of(const fs::path& out) { return read_json_file(out / "batch.json"); }

  // All that a map is known by.
  static void expect_same_maps(const fs::path& a, const fs::path& b) {
    for (const auto& [name, frames] : kScenes) {
      for (const char* file : {"mesh.ply", "objects.json"}) {
        EXPECT_EQ(read_file(a / name / file), read_file(b / name / file)) << name << " " << file;
      }
      EXPECT_EQ(read_json_file(a / name / "report.json").at("map_hash"), read_json_file(b / name / "report.json").at("map_hash"));
      EXPECT_EQ(read_json_file(a / name / "scene.json").at("map_hash"), read_json_file(a / name / "report.json").at("map_hash"));
    }
  }

  static inline const std::vector<std::pair<std::string, int>> kScenes = {{"a", 4}, {"b", 5}, {"c", 6}};
  fs::path scenes_;
  fs::path output_;
};

TEST_F(Batch, MapsEachSceneOnceAndTheSameBesideOthers) {
  const ProgramResult first = run_program(batch(output_, {"--jobs", "2"}));
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("3 scenes: 3 done (0 before), 0 failed"));
  const Json json = report_of(output_);
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_EQ(json.at("scenes").at(2).at("frames"), 6);
  EXPECT_GT(json.at("scenes").at(2).at("peak_mb"), 10);
  EXPECT_THAT(read_file(output_ / "batch.md"), HasSubstr("| c | done |"));

  const fs::path one_by_one = fresh_folder("outs_of_one") / "out";
  ASSERT_EQ(run_program(batch(one_by_one)).exit_code, 0);
  expect_same_maps(output_, one_by_one);

  const auto made = fs::last_write_time(output_ / "a" / "mesh.ply");
  const ProgramResult again = run_program(batch(output_));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("3 done (3 before)"));
  EXPECT_EQ(fs::last_write_time(output_ / "a" / "mesh.ply"), made);
}

TEST_F(Batch, MakesAnewWhatChanged) {
  ASSERT_EQ(run_program(batch(output_, {"--jobs", "2"})).exit_code, 0);
  write_file(scenes_ / "b" / "notes.txt", "moved");
  EXPECT_THAT(run_program(batch(output_)).out, HasSubstr("3 done (2 before)"));
  EXPECT_THAT(run_program(batch(output_, {"--jobs", "2"}, {"--frames", "0:3"})).out, HasSubstr("3 done (0 before)"));
  EXPECT_EQ(report_of(output_).at("scenes").at(2).at("frames"), 3);
}

TEST_F(Batch, GoesOnAfterAFailureAndSaysWhy) {
  fs::create_directories(scenes_ / "broken");
  write_file(scenes_ / "readme.txt", "x");
  const ProgramResult result = run_program(batch(output_));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("note: 1 names in"));
  expect_one_line(result.err, "1 of 4 scenes failed");
  const Json failed = report_of(output_).at("scenes").at(2);
  EXPECT_EQ(failed.at("name"), "broken");
  EXPECT_EQ(failed.at("state"), "failed");
  EXPECT_EQ(failed.at("attempts"), 2);
  EXPECT_THAT(failed.at("reason").get<std::string>(), HasSubstr("broken"));
  EXPECT_THAT(read_file(output_ / "broken" / "log.txt"), HasSubstr(failed.at("reason").get<std::string>()));
  fs::remove_all(scenes_ / "broken");
  EXPECT_THAT(run_program(batch(output_)).out, HasSubstr("3 scenes: 3 done (3 before)"));
}

TEST_F(Batch, RefusesAtOnceWhatCannotBe) {
  const auto why = [&](const Words& own, const Words& more, int code) {
    const ProgramResult result = run_program(batch(output_, own, more));
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(test::lines(result.err).size(), 1U) << result.err;
    EXPECT_FALSE(fs::exists(output_));
    return result.err;
  };
  EXPECT_THAT(why({}, {"--set", "map.voxel_size=1"}, 2), HasSubstr("map.voxel_size"));
  EXPECT_THAT(why({}, {"--no-such"}, 2), HasSubstr("after --: "));
  EXPECT_THAT(why({}, {"kitchen"}, 2), HasSubstr("kitchen"));
  EXPECT_THAT(why({}, {"-o", "elsewhere"}, 2), HasSubstr("each scene its own output"));
  EXPECT_THAT(why({}, {"--map=x"}, 2), HasSubstr("--map after --"));
  EXPECT_THAT(why({}, {"--view"}, 2), HasSubstr("nobody looks on"));
  EXPECT_THAT(why({}, {"--help"}, 2), HasSubstr("panoptic run --help"));
  EXPECT_THAT(why({}, {"--predictions", "p"}, 2), HasSubstr("would have the same"));
  EXPECT_THAT(why({}, {"--semantic", "absent.toml"}, 1), HasSubstr("absent.toml"));
  EXPECT_THAT(why({"--gt"}, {}, 1), HasSubstr("3 of 3 scenes have no ScanNet truth"));
  EXPECT_THAT(why({"--share-predictions", fresh_folder("p").string()}, {}, 1), HasSubstr("no predictions of a here"));
  const fs::path inside = scenes_ / "a" / "out";
  EXPECT_EQ(run_program(batch(inside)).exit_code, 1) << "outputs would change the recording";
  EXPECT_EQ(run_program({"batch", scenes_.string(), "-o", scenes_.string()}).exit_code, 1) << "so would they here";
  const fs::path link = fresh_folder("links") / "link";
  fs::create_directory_symlink(scenes_, link);
  EXPECT_EQ(run_program({"batch", scenes_.string(), "-o", link.string()}).exit_code, 1) << "and through a link";
  EXPECT_THAT(why({"--share-predictions", output_.string()}, {}, 1), HasSubstr("lie in each other"));
  EXPECT_THAT(why({}, {"--set", "predictions=p"}, 2), HasSubstr("would have the same"));
  EXPECT_EQ(run_program({"batch", scenes_.string()}).exit_code, 2);
}

TEST_F(Batch, TakesThePredictionsOfEachScene) {
  for (const auto& [name, frames] : kScenes) fs::copy(write_predictions(), scenes_ / name / "predictions");
  ASSERT_EQ(run_program(batch(output_, {}, {"--predictions", "{}/predictions"})).exit_code, 0);
  const fs::path shared = fresh_folder("shared");
  for (const auto& [name, frames] : kScenes) fs::copy(write_predictions(), shared / name);
  const fs::path other = fresh_folder("outs_of_others") / "out";
  ASSERT_EQ(run_program(batch(other, {}, {"--predictions", shared.string() + "/{name}"})).exit_code, 0);
  expect_same_maps(output_, other);
  const fs::path third = fresh_folder("outs_of_third") / "out";
  ASSERT_EQ(run_program(batch(third, {"--share-predictions", shared.string()})).exit_code, 0);
  expect_same_maps(output_, third);
}

TEST_F(Batch, MakesPredictionsOnceForAllBatches) {
  const fs::path network = fresh_folder("network");
  write_file(network / "colors.onnx", test::color_classifier(8, 4, {9, 0, 0, 0, 9, 0, 0, 0, 9}));
  write_file(network / "colors.toml",
             "name = \"colors\"\ntask = \"semantic\"\ndecoder = \"semantic_logits\"\nweights = \"colors.onnx\"\n"
             "classes = [\"wall\", \"floor\", \"chair\"]\n[input]\nwidth = 8\nheight = 4\n");
  const Words networks{"--semantic", (network / "colors.toml").string(), "--set", "networks.engine=opencv"};
  const fs::path shared = fresh_folder("shared");
  const ProgramResult first = run_program(batch(output_, {"--share-predictions", shared.string()}, networks));
  ASSERT_EQ(first.exit_code, 0) << first.err << read_file(output_ / "a" / "log.txt");
  const auto made = fs::last_write_time(shared / "a" / "000000.json");
  const fs::path other = fresh_folder("outs_of_others") / "out";
  ASSERT_EQ(run_program(batch(other, {"--share-predictions", shared.string()}, networks)).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(shared / "a" / "000000.json"), made);
  expect_same_maps(output_, other);
  Words fewer = networks;
  fewer.insert(fewer.end(), {"--frames", "0:2"});
  const ProgramResult refused = run_program(batch(output_, {"--share-predictions", shared.string()}, fewer));
  EXPECT_EQ(refused.exit_code, 1);
  expect_one_line(refused.err, "predictions of other networks, options or frames");
  EXPECT_THAT(run_program(batch(other, {"--share-predictions", shared.string()}, networks)).out, HasSubstr("3 done (3 before)"));
}

TEST_F(Batch, HasOneOwner) {
  const Words slow = batch(output_, {}, {"--online", "--speed", "0.01"});
  const ProgramResult owner = run_program(
      slow, [] { ::setpgid(0, 0); },
      [&](const test::RunningProgram& program) {
        ASSERT_TRUE(test::wait_for_text(program, output_ / "a" / "log.txt", "labels"));
        const ProgramResult refused = run_program(batch(output_));
        EXPECT_EQ(refused.exit_code, 1);
        expect_one_line(refused.err, "another batch writes");
        ::kill(-program.pid, SIGINT);
      });
  EXPECT_EQ(owner.exit_code, 130) << owner.err;
  EXPECT_EQ(report_of(output_).at("waiting"), 3);
  EXPECT_EQ(report_of(output_).at("failed"), 0);
  EXPECT_EQ(run_program(batch(output_)).exit_code, 0) << "free again";
}

TEST_F(Batch, KilledAtAnyMomentGoesOnToTheSameResult) {
  const fs::path undisturbed = fresh_folder("outs_undisturbed") / "out";
  const Stopwatch stopwatch;
  ASSERT_EQ(run_program(batch(undisturbed, {"--jobs", "2"})).exit_code, 0);
  const double whole_s = stopwatch.seconds();
  std::mt19937 random(test::fresh_seed());
  for (int round = 0; round < 3; ++round) {
    const fs::path out = fresh_folder("outs_killed") / "out";
    const double moment_s = std::uniform_real_distribution(0.1 * whole_s, 0.9 * whole_s)(random);
    const bool is_whole_tree = round != 1;  // or the batch alone, whose programs die with it
    run_program(
        batch(out, {"--jobs", "2"}), [] { ::setpgid(0, 0); },
        [&](const test::RunningProgram& program) {
          std::this_thread::sleep_for(std::chrono::duration<double>(moment_s));
          ::kill(is_whole_tree ? -program.pid : program.pid, SIGKILL);
        });
    const ProgramResult resumed = run_program(batch(out, {"--jobs", "2"}));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    expect_same_maps(out, undisturbed);
  }
}

// Two homes with truth, so small that they are made in seconds.
fs::path write_homes() {
  fs::path homes = fresh_folder("homes");
  for (const char* seed : {"4", "5"}) {
    run_program(
        {"simulate", "--seed", seed, "--rooms", "1", "--frames", "6", "-o", (homes / ("home" + std::string(seed))).string()});
  }
  return homes;
}

TEST(BatchScores, AreThoseOfAllScenesTogether) {
  const fs::path homes = write_homes();
  const fs::path out = fresh_folder("outs") / "out";
  const Words mapped{
      "batch",         homes.string(),  "-o", out.string(), "--", "--no-pictures", "--set", "map.voxel_size_m=0.06",
      "--predictions", "{}/predictions"};
  ASSERT_EQ(run_program(mapped).exit_code, 0);
  Words scored = mapped;
  scored.insert(scored.begin() + 4, "--gt");
  const ProgramResult result = run_program(scored);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("2 scenes"));
  EXPECT_EQ(test::lines(read_file(out / "home4" / "log.txt")).size() > 5, true) << "the map was not made again";
  EXPECT_THAT(read_file(out / "batch.md"), HasSubstr("## Scores"));

  const fs::path all = fresh_folder("all");
  for (const char* home : {"home4", "home5"}) {
    fs::copy(out / home / "submission", all, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  }
  const Json scores = read_json_file(out / "scores.json");
  const fs::path json = all / "scores.json";
  for (const char* form : {"semantic", "instance", "panoptic"}) {
    const ProgramResult eval = run_program(
        {"eval", form, "--pred", (all / form).string(), "--gt", (all / "truth" / form).string(), "--json", json.string()});
    ASSERT_EQ(eval.exit_code, 0) << eval.err;
    const Json part = read_json_file(json);
    for (const char* key : {"miou", "ap", "ap50", "ap25", "pq", "sq", "rq"}) {
      if (part.contains(key)) {
        EXPECT_EQ(part[key], scores[key]) << form << " " << key;
      }
    }
  }
  EXPECT_GT(scores.at("miou"), 0.0);
}

}  // namespace
}  // namespace panoptic
