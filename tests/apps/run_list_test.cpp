// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run` on a list of recordings: two rooms beside each other as one map.
#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/mapping/mapping_run.h"
#include "panoptic/run_outputs.h"
#include "panoptic/source.h"
#include "tests/apps/run_fixture.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::ProgramResult;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr double kApart_m = 6;
constexpr int kSecondFrames = 8;

class RunList : public test::Run {
 protected:
  RunList() : second_(fresh_folder("second")), predictions_(write_predictions()), list_(fresh_folder("list") / "rooms.toml") {
    test::write_orbit_recording(second_, kSecondFrames);
    write_list(fmt::format("translation = [{}, 0, 0]", kApart_m));
  }

  // Both with predictions; `second`: what else the list says of the second.
  void write_list(const std::string& second) const {
    write_file(list_, fmt::format("[[recording]]\npath = \"{0}\"\npredictions = \"{2}\"\n"
                                  "[[recording]]\npath = \"{1}\"\npredictions = \"{2}\"\n{3}\n",
                                  recording_.string(), second_.string(), predictions_.string(), second));
  }
  ProgramResult run_list(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"run", "--no-pictures", list_.string(), "-o", out_.string(), kCoarse[0], kCoarse[1]};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::run_program(arguments);
  }
  static Options options() {
    Options options;
    set_option(options, kCoarse[1]);
    return options;
  }

  fs::path second_;
  fs::path predictions_;
  fs::path list_;
};

TEST_F(RunList, MakesTheMapOfTheSameFramesAddedByHand) {
  const ProgramResult result = run_list();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto predictor = make_file_predictor(predictions_);
  Mapper mapper(options(), predictor->labels());
  const auto first = open_recording(recording_);
  for (const Frame& frame : *first) ASSERT_TRUE(mapper.add(frame, predictor->predict(frame)).used);
  const auto second = open_recording(second_);
  for (Frame frame : *second) {
    const Segmentation segmentation = predictor->predict(frame);
    frame.index += kFrames;
    frame.world_from_camera.translation().x() += kApart_m;
    ASSERT_TRUE(mapper.add(frame, segmentation).used);
  }
  mapper.finish();
  EXPECT_EQ(report()["map_hash"], fmt::format("{:016x}", mapper.map().voxels.hash()));
  const VoxelMap& voxels = mapper.map().voxels;
  EXPECT_EQ(report()["observed_voxels"], voxels.observed_voxels());
  EXPECT_NEAR(report()["memory_bytes_per_observed_voxel"].get<double>() * static_cast<double>(voxels.observed_voxels()),
              report()["map_memory_mb"].get<double>() * 1e6, 1);
  EXPECT_NEAR(report()["map_memory_mb"].get<double>(), static_cast<double>(voxels.memory_bytes()) / 1e6, 0.1);
  EXPECT_GT(report()["peak_rss_mb"].get<double>(), report()["map_memory_mb"].get<double>());
  EXPECT_EQ(report()["frames"]["used"], kFrames + kSecondFrames);
  EXPECT_EQ(report()["frames"]["without_prediction"], 0);
  EXPECT_EQ(report()["predictor"], "the predictions of " + list_.string());
}

TEST_F(RunList, BothBallsAreObjectsAndTheReportSaysWhereFramesAre) {
  ASSERT_EQ(run_list().exit_code, 0);
  const Json objects = read_json_file(out_ / "objects.json")["objects"];
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_NEAR(objects[1]["centroid_m"][0].get<double>() - objects[0]["centroid_m"][0].get<double>(), kApart_m, 0.2);
  EXPECT_EQ(objects[1]["first_frame"], kFrames);
  EXPECT_EQ(objects[1]["last_frame"], kFrames + kSecondFrames - 1);
  const Json recordings = report()["recordings"];
  ASSERT_EQ(recordings.size(), 2U);
  EXPECT_EQ(recordings[1]["recording"], second_.string());
  EXPECT_EQ(recordings[1]["predictions"], predictions_.string());
  EXPECT_EQ(recordings[1]["calibration"], nullptr);
  EXPECT_EQ(recordings[1]["first_frame"], kFrames);
  EXPECT_EQ(recordings[1]["frames"], kSecondFrames);
  EXPECT_EQ(recordings[1]["translation"], Json({kApart_m, 0, 0}));
  EXPECT_THAT(report()["dataset"], HasSubstr("2 recordings, 20 frames"));
}

TEST_F(RunList, FramesCountsPositionsThroughAllRecordingsAndExplainFindsThem) {
  ASSERT_EQ(run_list({"--frames", "10:16"}).exit_code, 0);
  EXPECT_EQ(report()["frames"]["used"], 6);
  const Json objects = read_json_file(out_ / "objects.json")["objects"];
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[1]["first_frame"], kFrames);
  const ProgramResult explained =
      test::run_program({"explain", out_.string(), objects[1]["id"].dump(), "--png", (out_ / "x.png").string()});
  EXPECT_EQ(explained.exit_code, 0) << explained.err;
  EXPECT_THAT(explained.out, HasSubstr("seen           frames 12 to 15, "));
}

// One map, mapped up to a position of the second recording, and then to the end.
TEST_F(RunList, AnInterruptedRunGoesOnInTheMiddleOfTheSecondRecording) {
  const fs::path map = list_.parent_path() / "map.panoptic";
  const auto map_until = [&](std::size_t end) {
    const auto dataset = open_recording(list_);
    const auto predictor = make_predictor(options(), *dataset);
    Mapper mapper(options(), predictor->labels());
    RunIdentity identity{list_.string(), "", "", options()};
    identity.recordings = to_text(recordings_of(*dataset));
    Checkpoints checkpoints({.path = map, .resume = true, .every_s = 1e9}, identity, mapper);
    const MappingResult result =
        map_offline({*dataset, {}, predictor.get(), mapper, &checkpoints, {}, [&](std::size_t done) { return done < end; }});
    EXPECT_EQ(result.failure, "");
    return std::pair(checkpoints.positions(), mapper.map().voxels.hash());
  };
  EXPECT_EQ(map_until(15).first, 15U);
  const auto [positions, hash] = map_until(SIZE_MAX);
  EXPECT_EQ(positions, 20U);
  ASSERT_EQ(run_list().exit_code, 0);
  EXPECT_EQ(report()["map_hash"], fmt::format("{:016x}", hash));
}

TEST_F(RunList, IsNotResumedIfTheListSaysSomethingElseByThen) {
  const std::string map = (list_.parent_path() / "map.panoptic").string();
  ASSERT_EQ(run_list({"--map", map}).exit_code, 0);
  write_list("translation = [5, 0, 0]");
  const ProgramResult moved = run_list({"--map", map, "--resume"});
  EXPECT_EQ(moved.exit_code, 1);
  expect_one_line(moved.err, "its recordings is");
  EXPECT_THAT(moved.err, HasSubstr("1 0 0 5 "));
}

TEST_F(RunList, ARecordingOnItsSideIsRefusedBeforeAnythingIsMapped) {
  write_list("rotation = [1, 0, 0, 0, 0, -1, 0, 1, 0]\ntranslation = [6, 0, 0]");
  const ProgramResult refused = run_list();
  EXPECT_EQ(refused.exit_code, 1);
  expect_one_line(refused.err, "its upward direction");
  EXPECT_THAT(refused.err, HasSubstr("--no-preflight"));
  EXPECT_EQ(run_list({"--no-preflight"}).exit_code, 0);
}

TEST_F(RunList, OptionsThatAreOfOneRecordingAreRefused) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--calibration", "c.toml"}, {"--pair-tolerance", "0.1"}}) {
    const ProgramResult result = run_list(more);
    EXPECT_EQ(result.exit_code, 1);
    expect_one_line(result.err, "a list says");
  }
}

TEST_F(RunList, PredictionsOfAnotherLabelSetThanTheFirstOnesAreRefused) {
  const fs::path other = fresh_folder("other");
  PredictionWriter(other, load_label_set("scannet20"), "test").write(0, {Image<std::uint16_t>(160, 120), {}});
  write_list("");
  std::string text = read_file(list_);
  text.replace(text.rfind(predictions_.string()), predictions_.string().size(), other.string());
  write_file(list_, text);
  const ProgramResult result = run_list();
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "are of the label set 'scannet20', those of");
}

TEST_F(RunList, WhatTheCommandLineNamesReplacesThePredictionsOfTheList) {
  const fs::path none = fresh_folder("of_frames_12_to_19");
  const auto predictor = make_file_predictor(predictions_);
  PredictionWriter writer(none, predictor->labels(), "test");
  const auto second = open_recording(second_);
  for (const Frame& frame : *second) writer.write(frame.index + kFrames, predictor->predict(frame));
  ASSERT_EQ(run_list({"--predictions", none.string()}).exit_code, 0);
  EXPECT_EQ(report()["frames"]["without_prediction"], kFrames);
  EXPECT_EQ(report()["predictor"], none.string());
}

}  // namespace
}  // namespace panoptic
