// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared by the tests of `panoptic run` from outside: a recording, an output folder, predictions.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/predict/prediction_io.h"
#include "tests/apps/program.h"
#include "tests/fresh_folder.h"
#include "tests/fusion/scenes.h"

namespace panoptic::test {

class Run : public testing::Test {
 protected:
  Run() : recording_(fresh_folder("recording")), out_(fresh_folder("out")) { write_orbit_recording(recording_, kFrames); }

  static constexpr int kFrames = 12;
  // A later --set wins, where a test needs more voxels. With those of the default size a run takes four times as long.
  static inline const std::vector<std::string> kCoarse = {"--set", "map.voxel_size_m=0.06"};

  // Without pictures, which take longer than all the rest, unless a test is about them.
  ProgramResult run(std::vector<std::string> more = {}) const {
    more.emplace_back("--no-pictures");
    return run_with_pictures(more);
  }
  ProgramResult run_with_pictures(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"run", recording_.string(), "-o", out_.string(), kCoarse[0], kCoarse[1]};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  Json report() const { return read_json_file(out_ / "report.json"); }
  std::filesystem::path file(int frame, const std::string& kind) const {
    return recording_ / fmt::format("frame-{:06}.{}", frame, kind);
  }

  // Predictions in which the ball is a chair whose segment number changes from frame to frame.
  static std::filesystem::path write_predictions() {
    std::filesystem::path folder = fresh_folder("predictions");
    fill_once(folder, "predictions", [&] {
      const LabelSet labels = load_label_set("indoor");
      PredictionWriter writer(folder, labels, "test");
      for (int i = 0; i < kFrames; ++i) writer.write(i, prediction(i, labels));
    });
    return folder;
  }

  std::filesystem::path recording_;
  std::filesystem::path out_;

 protected:
  static Segmentation prediction(int index, const LabelSet& labels) {
    const ClassId chair = labels.find("chair")->id;
    const ClassId floor = labels.find("floor")->id;
    const Frame frame = orbit_frame(index);
    Segmentation s{Image<std::uint16_t>(160, 120), {{chair, 0.8F, {{chair, 1.0F}}}, {floor, 1, {}}}};
    if (index % 2 == 1) std::swap(s.segments[0], s.segments[1]);
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
        s.segment_at(u, v) = static_cast<std::uint16_t>((p.y() > 0.599) == (index % 2 == 0) ? 2 : 1);
      }
    }
    return s;
  }
};

// Nothing on stderr but progress and one line for a person, which holds the part.
inline void expect_one_line(const std::string& err, const std::string& part) {
  EXPECT_THAT(err, testing::HasSubstr(part));
  const auto all = lines(err);
  EXPECT_EQ(std::count_if(all.begin(), all.end(), [](const std::string& l) { return l.starts_with("panoptic: "); }), 1) << err;
}

}  // namespace panoptic::test
