// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How the stages of the online pipeline hand things to each other. Everything here is thread-safe, and whoever waits is woken
// when the thing is closed.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace panoptic {

enum class Pushed { kYes, kFull, kClosed };

// First in, first out, never more than `capacity` at a time.
template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

  // Does not wait.
  Pushed try_push(T value) {
    const std::lock_guard lock(mutex_);
    if (closed_) return Pushed::kClosed;
    if (values_.size() >= capacity_) return Pushed::kFull;
    add(std::move(value));
    return Pushed::kYes;
  }
  // Waits for room. `extra` places beyond the capacity are kept for those who ask for them.
  Pushed push(T value, std::size_t extra = 0) {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [&] { return closed_ || values_.size() < capacity_ + extra; });
    if (closed_) return Pushed::kClosed;
    add(std::move(value));
    return Pushed::kYes;
  }
  // Waits for a value; nothing when the queue is closed and empty.
  std::optional<T> pop() {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, [&] { return closed_ || !values_.empty(); });
    if (values_.empty()) return std::nullopt;
    std::optional<T> value = std::move(values_.front());
    values_.pop_front();
    room_.notify_all();
    return value;
  }
  // Nothing goes in any more; what is inside still comes out.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    room_.notify_all();
    filled_.notify_all();
  }
  // Closes, and hands back what was inside.
  std::deque<T> abandon() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    room_.notify_all();
    filled_.notify_all();
    return std::exchange(values_, {});
  }

 private:
  void add(T value) {
    values_.push_back(std::move(value));
    filled_.notify_one();
  }

  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable room_;
  std::condition_variable filled_;
  std::deque<T> values_;
  bool closed_ = false;
};

// Holds the newest value alone.
template <typename T>
class Mailbox {
 public:
  // True if an older value was passed over by this.
  bool put(T value) {
    const std::lock_guard lock(mutex_);
    if (closed_) return false;
    const bool replaced = value_.has_value();
    value_ = std::move(value);
    filled_.notify_one();
    return replaced;
  }
  // Waits for a value; nothing when the box is closed and empty.
  std::optional<T> take() {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, [&] { return closed_ || value_.has_value(); });
    return std::exchange(value_, std::nullopt);
  }
  // Nothing goes in any more; what is inside still comes out.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    filled_.notify_all();
  }
  // Closes, and empties it; true if there was something inside.
  bool abandon() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    filled_.notify_all();
    return std::exchange(value_, std::nullopt).has_value();
  }

 private:
  std::mutex mutex_;
  std::condition_variable filled_;
  std::optional<T> value_;
  bool closed_ = false;
};

// Takes any number of values at any time; all are taken out together, in their order.
template <typename T>
class Tray {
 public:
  void put(T value) {
    const std::lock_guard lock(mutex_);
    values_.push_back(std::move(value));
  }
  std::vector<T> take_all() {
    const std::lock_guard lock(mutex_);
    return std::exchange(values_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<T> values_;
};

// A mutex that is given to those who wait in the order in which they came: a thread that takes it again and again, as fusion
// does, cannot keep the others out.
class FairMutex {
 public:
  void lock() {
    std::unique_lock lock(mutex_);
    const std::uint64_t mine = next_++;
    turn_.wait(lock, [&] { return mine == serving_; });
  }
  void unlock() {
    const std::lock_guard lock(mutex_);
    ++serving_;
    turn_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable turn_;
  std::uint64_t next_ = 0;
  std::uint64_t serving_ = 0;
};

}  // namespace panoptic
