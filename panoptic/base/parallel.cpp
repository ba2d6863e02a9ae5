// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/parallel.h"

#include <algorithm>
#include <thread>

#include "panoptic/base/os.h"
#include "panoptic/error.h"

#ifdef PANOPTIC_PARALLEL_TBB
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <memory>
#include <mutex>
#else
#include <atomic>
#include <exception>
#include <mutex>
#include <vector>
#endif

namespace panoptic {
namespace {

int available_cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

int& configured_threads() {
  static int threads = available_cores();
  return threads;
}

}  // namespace

int thread_count() { return configured_threads(); }

#ifdef PANOPTIC_PARALLEL_TBB

namespace {

struct Workers {
  explicit Workers(int threads)
      : limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)), arena(threads) {}

  tbb::global_control limit;  // without it, TBB refuses more threads than cores
  tbb::task_arena arena;
};

std::unique_ptr<Workers> workers;
std::once_flag begun;
// True in a child of a process that had workers. They did not come along, and TBB, which does not know that, would wait for them
// whenever it begins or ends anything: it is left alone for good.
bool is_cut_off = false;

void cut_off() {
  is_cut_off = true;
  configured_threads() = 1;
  static_cast<void>(workers.release());
}

void begin() {
  workers = std::make_unique<Workers>(thread_count());
  if (!os::call_in_children(&cut_off)) throw Error("the system has no memory left to watch for forks");
}

}  // namespace

void set_thread_count(int threads) {
  if (is_cut_off) return;
  configured_threads() = threads > 0 ? threads : available_cores();
  std::call_once(begun, begin);
  workers = std::make_unique<Workers>(thread_count());
}

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  if (thread_count() == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::call_once(begun, begin);
  workers->arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, body); });
}

#else

void set_thread_count(int threads) { configured_threads() = threads > 0 ? threads : available_cores(); }

void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body) {
  const std::size_t workers = std::min(count, static_cast<std::size_t>(thread_count()));
  if (workers < 2) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) body(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(workers - 1);
  for (std::size_t t = 1; t < workers; ++t) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

#endif

}  // namespace panoptic
