// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic doctor` and `panoptic predict` from outside.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/predict/prediction_io.h"
#include "tests/apps/program.h"
#include "tests/fresh_folder.h"
#include "tests/predict/tiny_onnx.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;
using testing::StartsWith;
namespace fs = std::filesystem;

void spoil_depth(const fs::path& recording, int frames) {
  for (int i = 0; i < frames; ++i) {
    write_png(recording / fmt::format("frame-{:06}.depth.png", i), Image<std::uint16_t>(160, 120));
  }
}

// A network that takes red for wall, green for floor, blue for chair.
fs::path write_network() {
  const fs::path folder = fresh_folder("network");
  write_file(folder / "colors.onnx", test::color_classifier(8, 4, {9, 0, 0, 0, 9, 0, 0, 0, 9}));
  write_file(folder / "colors.toml",
             "name = \"colors\"\ntask = \"semantic\"\ndecoder = \"semantic_logits\"\nweights = \"colors.onnx\"\n"
             "classes = [\"wall\", \"floor\", \"chair\"]\n[input]\nwidth = 8\nheight = 4\n");
  return folder / "colors.toml";
}

// A network that takes everything for something that the label set does not know.
fs::path write_blind_network() {
  const fs::path folder = fresh_folder("network");
  write_file(folder / "blind.onnx", test::color_classifier(8, 4, {9, 9, 9, -9, -9, -9}));
  write_file(folder / "blind.toml",
             "name = \"blind\"\ntask = \"semantic\"\ndecoder = \"semantic_logits\"\nweights = \"blind.onnx\"\n"
             "classes = [\"everything\", \"chair\"]\n[input]\nwidth = 8\nheight = 4\n");
  return folder / "blind.toml";
}

// On OpenCV, which is always there and whose threads the thread sanitizer can follow.
ProgramResult predict(const fs::path& recording, const fs::path& predictions) {
  return run_program({"predict", recording.string(), "--semantic", write_network().string(), "--set", "networks.engine=opencv",
                      "-o", predictions.string()});
}

TEST(Doctor, SaysOnStderrHowManyChecksFailed) {
  const fs::path recording = fresh_folder("recording");
  test::write_orbit_recording(recording, 4);
  spoil_depth(recording, 4);
  const ProgramResult result = run_program({"doctor", recording.string()});
  EXPECT_EQ(result.exit_code, 1);
  const auto all = test::lines(result.out);
  const auto failed = std::count_if(all.begin(), all.end(), [](const std::string& l) { return l.starts_with("FAILED"); });
  ASSERT_GE(failed, 1) << result.out;
  EXPECT_EQ(result.err, fmt::format("panoptic: {} {} failed\n", failed, failed == 1 ? "check" : "checks"));
}

TEST(Doctor, IsQuietOnStderrAboutAGoodRecording) {
  const fs::path recording = fresh_folder("recording");
  test::write_orbit_recording(recording, 12);
  const ProgramResult result = run_program({"doctor", recording.string()});
  EXPECT_EQ(result.exit_code, 0) << result.out;
  EXPECT_EQ(result.err, "");
}

TEST(Doctor, WritesJson) {
  const fs::path recording = fresh_folder("recording");
  test::write_orbit_recording(recording, 12);
  const ProgramResult result = run_program({"doctor", recording.string(), "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const auto json = json_in(result.out);
  ASSERT_TRUE(json) << result.out;
  EXPECT_EQ((*json)["recording"], recording.string());
  EXPECT_EQ((*json)["checks"][0]["name"], "frames");
  EXPECT_EQ((*json)["checks"][0]["verdict"], "ok");
}

// Maps the recording with intrinsics that are shares of the image's size.
ProgramResult run_with_shares(const fs::path& out, const std::vector<std::string>& more = {}) {
  const fs::path recording = fresh_folder("recording");
  test::write_orbit_recording(recording, 4);
  write_file(recording / "camera-intrinsics.txt", std::string("0.9 0 0.5\n0 1.2 0.5\n0 0 1\n"));
  std::vector<std::string> arguments = {"run", "--no-pictures", recording.string(), "-o", out.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments);
}

TEST(Preflight, RefusesImpossibleNumbersBeforeTheFirstFrame) {
  const fs::path out = fresh_folder("out");
  const ProgramResult result = run_with_shares(out);
  EXPECT_EQ(result.exit_code, 1);
  ASSERT_EQ(test::lines(result.err).size(), 1U) << result.err;
  EXPECT_THAT(result.err, testing::AllOf(HasSubstr("fx = 0.9, fy = 1.2 pixels for images 160x120: intrinsics are in pixels"),
                                         HasSubstr("--no-preflight")));
  EXPECT_FALSE(fs::exists(out / "report.json"));
}

TEST(Preflight, WarnsInOneLineThatNamesTheDoctor) {
  const fs::path recording = fresh_folder("recording");
  test::write_orbit_recording(recording, 12);
  const fs::path calibration = fresh_folder("calibration") / "wrong.toml";
  write_file(calibration, std::string("[depth]\nscale = 100\n"));
  const std::vector<std::string> run = {"run",
                                        "--no-pictures",
                                        recording.string(),
                                        "--calibration",
                                        calibration.string(),
                                        "--set",
                                        "depth.max_m=100",
                                        "--set",
                                        "map.voxel_size_m=0.2",
                                        "-o",
                                        fresh_folder("out").string()};
  const ProgramResult warned = run_program(run);
  ASSERT_FALSE(test::lines(warned.err).empty());
  EXPECT_THAT(test::lines(warned.err).front(),
              testing::AllOf(StartsWith("warning: depth scale: "), HasSubstr("panoptic doctor " + recording.string())));
  std::vector<std::string> quiet = run;
  quiet.emplace_back("--no-preflight");
  EXPECT_THAT(run_program(quiet).err, testing::Not(HasSubstr("warning")));
}

TEST(RunResult, WithoutSurfaceIsAnErrorAndStillWritesItsFiles) {
  const fs::path recording = fresh_folder("recording");
  test::write_orbit_recording(recording, 3);
  const fs::path out = fresh_folder("out");
  const ProgramResult result =
      run_program({"run", "--no-pictures", recording.string(), "--set", "mesher.min_weight=1000", "-o", out.string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(test::lines(result.err).back(), HasSubstr("no surface came of the 3 frames used"));
  EXPECT_TRUE(fs::exists(out / "report.json"));
}

TEST(RunResult, WithoutOneLabelThatCountedIsAnErrorAndStillWritesItsFiles) {
  const fs::path recording = fresh_folder("recording");
  test::write_orbit_recording(recording, 3);
  const fs::path out = fresh_folder("out");
  const ProgramResult result =
      run_program({"run", "--no-pictures", recording.string(), "--semantic", write_blind_network().string(), "--set",
                   "networks.engine=opencv", "-o", out.string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(test::lines(result.err).back(), HasSubstr("the network never gave a label that counted"));
  EXPECT_TRUE(fs::exists(out / "report.json"));
}

TEST(Predict, WritesPredictionsThatRunTakes) {
  const fs::path recording = fresh_folder("recording");
  const fs::path predictions = fresh_folder("predictions");
  test::write_orbit_recording(recording, 3);
  const ProgramResult result = predict(recording, predictions);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(open_predictions(predictions).labels.name(), "indoor");
  const fs::path out = fresh_folder("out");
  const ProgramResult run =
      run_program({"run", "--no-pictures", recording.string(), "--predictions", predictions.string(), "-o", out.string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(read_json_file(out / "report.json")["frames"]["without_prediction"], 0);
}

TEST(Predict, WithoutAUsableFrameIsOneLineAndExitCode1) {
  const fs::path recording = fresh_folder("recording");
  test::write_orbit_recording(recording, 3);
  spoil_depth(recording, 3);
  const ProgramResult result = predict(recording, fresh_folder("out"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(test::lines(result.err).back(),
              testing::AllOf(StartsWith("panoptic: "), HasSubstr(recording.string()), HasSubstr("no frame was usable")));
}

}  // namespace
}  // namespace panoptic
