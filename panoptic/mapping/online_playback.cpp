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
  // All that comes is due so much later.
  void put_off(Clock::duration by) { start_ += by; }

 private:
  double speed_;
  bool started_ = false;
  double first_s_ = 0;
  Clock::time_point start_;
};

// Waits until a frame is due. False as soon as `go_on` says so.
bool wait_for(double time_s, Pace& pace, const OnlinePipeline& pipeline, const std::function<bool()>& go_on) {
  for (;;) {
    const Clock::time_point due = pace.due(time_s);
    const Clock::time_point now = Clock::now();
    const bool stands_still = pipeline.is_correcting();
    if (due <= now && !stands_still) return true;
    std::this_thread::sleep_for(stands_still ? kLook : std::min<Seconds>(due - now, kLook));
    if (stands_still) pace.put_off(Clock::now() - now);
    if (!go_on()) return false;
  }
}

}  // namespace

void play(const Dataset& dataset, const Playback& playback, OnlinePipeline& pipeline,
          const std::function<void(std::size_t done)>& look,
          const std::function<void(const ReadResult& read, std::size_t position)>& comes) {
  FrameStream stream(dataset, playback.range);
  Pace pace(playback.speed);
  std::size_t done = 0;
  const auto go_on = [&] {
    if (look) look(done);
    return !pipeline.stopped();
  };
  for (; go_on(); ++done) {
    std::optional<ReadResult> read = stream.next();
    if (!read) return;
    if (comes) comes(*read, playback.range.begin + done * playback.range.step);
    if (!read->frame) {
      pipeline.skip(read->skipped);
    } else if (playback.speed == Playback::kAsFastAsPossible) {
      pipeline.push_when_free(std::move(*read->frame));
    } else {
      if (!wait_for(read->frame->time_s, pace, pipeline, go_on)) return;
      pipeline.push(std::move(*read->frame));
    }
  }
}

}  // namespace panoptic
