// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>

namespace panoptic {

// Whether an online run takes more frames, and whether its stages are to end. Thread-safe.
class RunControl {
 public:
  using Clock = std::chrono::steady_clock;

  // No more frames are taken. The first reason counts.
  void stop(const std::string& why);
  // The same after a failure of a stage, the first of which counts; all stages are to end.
  void fail(std::exception_ptr failure);
  // Stages that wait for their time are to end.
  void end();

  bool stopped() const;
  std::string stopped_by() const;      // empty: nothing did
  std::exception_ptr failure() const;  // null: none
  // Waits; false as soon as the stages are to end.
  bool wait_until(Clock::time_point time);

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::string stopped_by_;
  std::exception_ptr failure_;
  bool stopped_ = false;
  bool ending_ = false;
};

}  // namespace panoptic
