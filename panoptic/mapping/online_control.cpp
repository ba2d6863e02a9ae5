// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/online_control.h"

#include <new>
#include <utility>

namespace panoptic {
namespace {

std::string text_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    return "out of memory";
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "an unknown failure";
  }
}

}  // namespace

void RunControl::stop(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(stopped_, true)) return;
  stopped_by_ = why;
}

void RunControl::fail(std::exception_ptr failure) {
  const std::lock_guard lock(mutex_);
  if (stopped_by_.empty()) stopped_by_ = text_of(failure);
  if (!failure_) failure_ = std::move(failure);
  stopped_ = true;
  ending_ = true;
  changed_.notify_all();
}

void RunControl::end() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  ending_ = true;
  changed_.notify_all();
}

bool RunControl::stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

std::string RunControl::stopped_by() const {
  const std::lock_guard lock(mutex_);
  return stopped_by_;
}

std::exception_ptr RunControl::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

bool RunControl::wait_until(Clock::time_point time) {
  std::unique_lock lock(mutex_);
  return !changed_.wait_until(lock, time, [this] { return ending_; });
}

}  // namespace panoptic
