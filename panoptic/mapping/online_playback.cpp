// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/online_playback.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <thread>
#include <utility>

namespace panoptic {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
constexpr Seconds kLook(0.05);

// When each frame is due: the first at once, the others as long after it as their time stamps say.
class Pace {
 public:
  explicit Pace(double speed) : speed_(speed) {}

  Clock::time_point due(double time_s) {
    if (!std::isfinite(time_s)) return Clock::now();
    if (!started_) {
      started_ = true;
      first_s_ = time_s;
      start_ = Clock::now();
    }
    constexpr double kLongest_s = 1e6;  // a wrong time stamp must not overflow the clock
    const double after_s = std::fmin((time_s - first_s_) / speed_, kLongest_s);
    return start_ + std::chrono::duration_cast<Clock::duration>(Seconds(std::fmax(after_s, 0)));
  }

 private:
  double speed_;
  bool started_ = false;
  double first_s_ = 0;
  Clock::time_point start_;
};

}  // namespace

void play(const Dataset& dataset, const Playback& playback, OnlinePipeline& pipeline,
          const std::function<void(std::size_t done)>& look) {
  FrameStream stream(dataset, playback.range);
  Pace pace(playback.speed);
  const auto go_on = [&](std::size_t done) {
    if (look) look(done);
    return !pipeline.stopped();
  };
  for (std::size_t done = 0; go_on(done); ++done) {
    std::optional<ReadResult> read = stream.next();
    if (!read) return;
    if (!read->frame) {
      pipeline.skip(read->skipped);
    } else if (playback.speed == Playback::kAsFastAsPossible) {
      pipeline.push_when_free(std::move(*read->frame));
    } else {
      const Clock::time_point due = pace.due(read->frame->time_s);
      for (auto left = due - Clock::now(); left.count() > 0; left = due - Clock::now()) {
        std::this_thread::sleep_for(std::min<Seconds>(left, kLook));
        if (!go_on(done)) return;
      }
      pipeline.push(std::move(*read->frame));
    }
  }
}

}  // namespace panoptic
