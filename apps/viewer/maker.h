// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One thread that makes answers for the others, in turn.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace panoptic {

// The C library gives every thread that allocates a heap of its own and returns little of it. Answers made on whichever
// connection's thread asked would leave the memory of the largest one in each of those heaps; made here they leave it once.
// And mapping keeps the other cores to itself.
class Maker {
 public:
  Maker() : thread_([this] { work(); }) {}
  ~Maker() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  Maker(const Maker&) = delete;
  Maker& operator=(const Maker&) = delete;

  // Runs the task when its turn comes; returns or throws what the task does. Thread-safe; not from within a task.
  template <typename Task>
  auto make(Task task) {
    auto job = std::make_shared<std::packaged_task<decltype(task())()>>(std::move(task));
    auto made = job->get_future();
    {
      const std::lock_guard lock(mutex_);
      jobs_.emplace_back([job] { (*job)(); });
    }
    wake_.notify_one();
    return made.get();
  }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
      if (jobs_.empty()) return;
      std::function<void()> job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      job();
      job = nullptr;
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> jobs_;
  bool ending_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace panoptic
