// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Reading a dataset in order, ahead of whoever uses the frames.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

std::size_t range_part(std::string_view part, std::size_t missing, const std::string& text) {
  if (part.empty()) return missing;
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (error == std::errc{} && end == part.data() + part.size()) return value;
  throw Error(
      fmt::format("frame range '{}': '{}' is not a frame position; write A:B or A:B:STEP, for example 0:100:2", text, part));
}

}  // namespace

FrameRange parse_frame_range(const std::string& text) {
  const auto colons = std::count(text.begin(), text.end(), ':');
  if (colons < 1 || colons > 2) {
    throw Error(fmt::format("frame range '{}': expected A:B or A:B:STEP, for example 0:100 or ::5", text));
  }
  const std::string_view all(text);
  const std::size_t first = all.find(':');
  const std::size_t second = std::min(all.find(':', first + 1), all.size());
  const std::string_view step = second < all.size() ? all.substr(second + 1) : std::string_view();
  FrameRange range;
  range.begin = range_part(all.substr(0, first), range.begin, text);
  range.end = range_part(all.substr(first + 1, second - first - 1), range.end, text);
  range.step = range_part(step, range.step, text);
  if (range.step == 0) throw Error(fmt::format("frame range '{}': the step is 0; use 1 for every frame", text));
  if (range.begin >= range.end) throw Error(fmt::format("frame range '{}': is empty, since B is not after A", text));
  return range;
}

std::size_t FrameRange::count(std::size_t dataset_size) const {
  PANOPTIC_ASSERT(step > 0);
  const std::size_t last = std::min(end, dataset_size);
  return begin < last ? (last - begin - 1) / step + 1 : 0;
}

struct FrameStream::State {
  State(const Dataset& d, FrameRange r, std::size_t a) : dataset(d), range(r), ahead(std::max<std::size_t>(a, 1)) {}

  // The decoding thread.
  void run() {
    std::exception_ptr thrown;
    try {
      decode_all();
    } catch (...) {
      thrown = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    failure = thrown;
    finished = true;
    filled.notify_one();
  }

  void decode_all() {
    const std::size_t count = range.count(dataset.size());
    for (std::size_t i = 0; i < count && wait_for_room(); ++i) {
      ReadResult result = dataset.read(range.begin + i * range.step);
      const std::lock_guard lock(mutex);
      queue.push_back(std::move(result));
      filled.notify_one();
    }
  }

  // False: stop.
  bool wait_for_room() {
    std::unique_lock lock(mutex);
    room.wait(lock, [this] { return stop || queue.size() < ahead; });
    return !stop;
  }

  const Dataset& dataset;
  const FrameRange range;
  const std::size_t ahead;

  std::mutex mutex;
  std::condition_variable room;    // the queue is shorter than ahead, or stop
  std::condition_variable filled;  // the queue holds something, or finished
  std::deque<ReadResult> queue;
  std::exception_ptr failure;
  bool finished = false;
  bool stop = false;
  std::thread thread;
};

FrameStream::FrameStream(const Dataset& dataset, FrameRange range, std::size_t ahead)
    : state_(std::make_unique<State>(dataset, range, ahead)) {
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

FrameStream::~FrameStream() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
  }
  state_->room.notify_one();
  state_->thread.join();
}

std::optional<ReadResult> FrameStream::next() {
  std::unique_lock lock(state_->mutex);
  state_->filled.wait(lock, [&] { return !state_->queue.empty() || state_->finished; });
  if (state_->queue.empty()) {
    if (state_->failure) std::rethrow_exception(std::exchange(state_->failure, nullptr));
    return std::nullopt;
  }
  ReadResult result = std::move(state_->queue.front());
  state_->queue.pop_front();
  state_->room.notify_one();
  return result;
}

FrameIterator::FrameIterator(const Dataset& dataset) : stream_(std::make_shared<FrameStream>(dataset)) { ++*this; }

FrameIterator& FrameIterator::operator++() {
  frame_.reset();
  while (std::optional<ReadResult> result = stream_->next()) {
    if (!result->frame) continue;
    frame_ = std::move(result->frame);
    break;
  }
  return *this;
}

FrameIterator Dataset::begin() const { return FrameIterator(*this); }

}  // namespace panoptic
