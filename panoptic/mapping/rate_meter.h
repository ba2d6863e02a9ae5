// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures how often something happens: over the last seconds, and in all.
#pragma once

#include <cstdint>
#include <deque>

namespace panoptic {

// Times are seconds of any clock that does not go back. Not thread-safe.
class RateMeter {
 public:
  static constexpr double kWindow_s = 3;

  void count(double now_s) {
    if (count_++ == 0) first_s_ = now_s;
    last_s_ = now_s;
    recent_s_.push_back(now_s);
    forget(now_s);
  }

  // Events per second of the last kWindow_s; in the first kWindow_s of the clock, of the time since 0.
  double recent_hz(double now_s) {
    forget(now_s);
    const double over_s = now_s < kWindow_s ? now_s : kWindow_s;
    return over_s > 0 ? static_cast<double>(recent_s_.size()) / over_s : 0;
  }
  // Events per second from the first to the last; 0 with less than two.
  double hz() const { return last_s_ > first_s_ ? static_cast<double>(count_ - 1) / (last_s_ - first_s_) : 0; }

 private:
  void forget(double now_s) {
    while (!recent_s_.empty() && recent_s_.front() <= now_s - kWindow_s) recent_s_.pop_front();
  }

  std::deque<double> recent_s_;
  std::uint64_t count_ = 0;
  double first_s_ = 0;
  double last_s_ = 0;
};

}  // namespace panoptic
