// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How good the presets are, on frames of furnished homes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "panoptic/sim/prediction_noise.h"
#include "tests/sim/frame_score.h"

namespace panoptic::test {
namespace {

struct HomeFrames {
  std::uint64_t seed = 0;
  std::vector<SimulatedFrame> frames;
};

std::vector<HomeFrames> home_frames() {
  constexpr int kFrames = 16;
  std::vector<HomeFrames> homes;
  for (const std::uint64_t seed : {1U, 2U}) {
    const Simulation simulation({.seed = seed, .rooms = 4, .frames = kFrames, .noise = "none"});
    HomeFrames home{seed, {}};
    for (std::size_t i = 0; i < simulation.size(); ++i) home.frames.push_back(simulation.simulate(i));
    homes.push_back(std::move(home));
  }
  return homes;
}

FrameScore score_of(const std::string& preset, const std::vector<HomeFrames>& homes, std::uint64_t repeats) {
  const LabelSet labels = load_label_set("scannet20");
  const PredictionNoise noise = prediction_noise_preset(preset);
  FrameScore score(labels);
  for (const HomeFrames& home : homes) {
    for (std::uint64_t r = 0; r < repeats; ++r) {
      for (const SimulatedFrame& f : home.frames)
        score.add(predict_with_noise(noise, home.seed + 100 * r, f, labels), f.rendering);
    }
  }
  return score;
}

void expect_calibrated(const std::string& preset, const FrameScore& score) {
  for (const FrameScore::Bin& bin : score.bins()) {
    constexpr int kEnough = 80;
    if (bin.count < kEnough) continue;
    const double correct = static_cast<double>(bin.correct) / bin.count;
    EXPECT_NEAR(correct, bin.score_sum / bin.count, 0.12) << preset << ", " << bin.count << " findings";
  }
}

// In one test, since frames of homes are costly.
TEST(PredictionPresets, AreAsGoodAsTheyClaimAndKnowIt) {
  const std::vector<HomeFrames> homes = home_frames();
  const double oracle = score_of("oracle", homes, 1).pq();
  const FrameScore good = score_of("good", homes, 1);
  const FrameScore maskrcnn = score_of("maskrcnn", homes, 2);
  const FrameScore poor = score_of("poor", homes, 1);
  EXPECT_DOUBLE_EQ(oracle, 100);
  EXPECT_NEAR(good.pq(), 70, 10);
  EXPECT_NEAR(maskrcnn.pq(), 40, 6);
  EXPECT_NEAR(poor.pq(), 22, 10);
  expect_calibrated("good", good);
  expect_calibrated("maskrcnn", maskrcnn);
  expect_calibrated("poor", poor);
  RecordProperty("good_maskrcnn_poor", fmt::format("{:.1f} {:.1f} {:.1f}", good.pq(), maskrcnn.pq(), poor.pq()));
}

}  // namespace
}  // namespace panoptic::test
