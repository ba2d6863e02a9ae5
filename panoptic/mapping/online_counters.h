// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <vector>

#include "panoptic/mapping/rate_meter.h"
#include "panoptic/mapping/snapshot.h"
#include "panoptic/online.h"
#include "panoptic/profile.h"

namespace panoptic {

// Counts the frames of an online run by what became of them, and measures how long it took. Thread-safe.
class OnlineCounters {
 public:
  using Clock = std::chrono::steady_clock;

  // A frame was handed over; `passed_over`: the networks will not see the one before it.
  void arrived(bool dropped, bool passed_over);
  void unreadable();
  void corrected(const Correction& correction);
  // The geometry of a frame was fused, or refused.
  void fused(Clock::time_point read_at);
  void refused();
  void labelled(Clock::time_point read_at);
  // Frames that were read then are in a published snapshot.
  void visible(const std::vector<Clock::time_point>& read_at);
  void took(const char* stage, const Stopwatch& stopwatch);

  // For those who look on, while it runs.
  RunState run_state();
  // At the end: counts, rates and latencies.
  OnlineReport report() const;
  Profile stages() const;

 private:
  static double seconds_since(Clock::time_point time) { return std::chrono::duration<double>(Clock::now() - time).count(); }
  double now_s() const { return seconds_since(start_); }

  const Clock::time_point start_ = Clock::now();
  mutable std::mutex mutex_;
  OnlineReport report_;
  Profile stages_;
  RateMeter geometry_rate_;
  RateMeter label_rate_;
};

}  // namespace panoptic
