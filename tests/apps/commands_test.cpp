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
