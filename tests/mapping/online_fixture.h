// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared by the tests of the online pipeline: a small recording, predictors that know the truth, and trouble.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "panoptic/error.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/snapshot.h"
#include "panoptic/online.h"
#include "tests/mapping/ball_on_floor.h"

namespace panoptic::test {

using namespace std::chrono_literals;

inline Frame orbit_frame(int i) {
  static const Surface kScene = ball_on_floor();
  const double angle = 0.1 * i;
  Frame frame = render(kScene, small_camera(64, 48), look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), i);
  frame.time_s = 100 + i / 30.0;
  return frame;
}

// Makes each stage sleep for random times, and one of them throw at its n-th piece of work: what stages do to each other when the
// machine is busy or something breaks.
class Trouble {
 public:
  Trouble(std::uint64_t seed, int longest_us) : seed_(seed), longest_us_(longest_us) {}

  void break_stage(std::string stage, int call) {
    breaks_ = std::move(stage);
    breaks_at_ = call;
  }
  void operator()(std::string_view stage) {
    int call = 0;
    std::uint64_t random = 0;
    {
      const std::lock_guard lock(mutex_);
      call = ++calls_[std::string(stage)];
      random = std::mt19937_64(seed_ + calls_.size() * 1000 + static_cast<std::uint64_t>(call))();
    }
    if (longest_us_ > 0) std::this_thread::sleep_for(random % static_cast<std::uint64_t>(longest_us_) * 1us);
    if (stage == breaks_ && call == breaks_at_) throw Error(std::string(stage) + " broke");
  }
  int calls(const std::string& stage) {
    const std::lock_guard lock(mutex_);
    return calls_[stage];
  }

 private:
  const std::uint64_t seed_;
  const int longest_us_;
  std::string breaks_;
  int breaks_at_ = 0;
  std::mutex mutex_;
  std::map<std::string, int> calls_;
};

// A predictor of two networks that always say the same.
class Networks final : public Predictor {
 public:
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override { return segmented(frame); }
  std::optional<PredictorHalves> halves() override {
    return PredictorHalves{
        [](const ImageView<Rgb>& color) { return Image<ClassId>(color.width(), color.height(), ClassId{2}); },
        [](const ImageView<Rgb>& color) {
          const int width = color.width() / 2;
          const int height = color.height() / 2;
          const Segment ball{ClassId{3}, 0.9F, {{ClassId{3}, 1.0F}}};
          return std::vector<Instance>(1, {ball, width / 2, height / 2, Image<std::uint8_t>(width, height, 1)});
        },
        [this](const Image<ClassId>& classes, const std::vector<Instance>& found) { return fuse(classes, found, labels_); }};
  }

 private:
  LabelSet labels_ = test_labels();
};

// A predictor in one piece.
class Oracle final : public Predictor {
 public:
  explicit Oracle(std::chrono::microseconds takes = 0us) : takes_(takes) {}
  const LabelSet& labels() const override { return labels_; }
  Segmentation predict(const Frame& frame) override {
    std::this_thread::sleep_for(takes_);
    return segmented(frame);
  }

 private:
  std::chrono::microseconds takes_;
  LabelSet labels_ = test_labels();
};

// Frames made beforehand. Position 3 cannot be read; position 5 has a pose of NaN.
class Orbit final : public Dataset {
 public:
  explicit Orbit(int frames) {
    for (int i = 0; i < frames; ++i) frames_.push_back(orbit_frame(i));
    if (frames > 5) frames_[5].world_from_camera.translation().x() = std::nan("");
  }
  std::string description() const override { return "orbit"; }
  std::size_t size() const override { return frames_.size(); }
  ReadResult read(std::size_t position) const override {
    if (trouble != nullptr) (*trouble)("reading");
    if (position == 3) return {std::nullopt, {3, "unreadable"}};
    return {frames_[position], {}};
  }
  const std::vector<Frame>& frames() const { return frames_; }

  Trouble* trouble = nullptr;

 private:
  std::vector<Frame> frames_;
};

// A coarse map of what is near: stages meet as often in it, and each is done soon.
inline Options coarse() {
  Options options;
  options.map.voxel_size_m = 0.06F;
  options.depth.max_m = 3;
  return options;
}

struct OnlineRun {
  explicit OnlineRun(Predictor* predictor = nullptr, OnlineOptions options = quick())
      : pipeline({mapper, predictor, &latest}, options) {}
  OnlineRun(Predictor* predictor, Trouble& trouble, OnlineOptions options = quick())
      : pipeline({mapper, predictor, &latest, 0, std::ref(trouble)}, options) {}

  // Everything happens often, so that everything meets everything.
  static OnlineOptions quick() { return {.mesh_every_s = 0.05F, .regularize_every_s = 0.1F, .waiting_frames = 4}; }

  Mapper mapper{coarse(), test_labels()};
  LatestSnapshot latest;
  OnlinePipeline pipeline;
};

inline void expect_accounted(const OnlineReport& report) {
  EXPECT_EQ(report.read, report.used + report.skipped + report.dropped + report.lost);
  EXPECT_TRUE(report.failure != nullptr || report.lost == 0) << report.lost;
}

}  // namespace panoptic::test
