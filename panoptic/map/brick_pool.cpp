// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/brick_pool.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

namespace panoptic {
namespace {

constexpr std::size_t kHeapExtent = 384 * 1024;  // a whole number of bricks
constexpr std::size_t kAlignment = 64;

struct Aligned {
  void operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{kAlignment}); }
};

// Owns extents as long as the function that it is part of lives.
BrickPool::Extents heap_extents() {
  auto all = std::make_shared<std::vector<std::unique_ptr<std::byte, Aligned>>>();
  return [all](std::size_t bytes) {
    all->emplace_back(static_cast<std::byte*>(::operator new (bytes, std::align_val_t{kAlignment})));
    return all->back().get();
  };
}

}  // namespace

BrickPool::BrickPool() : BrickPool(kHeapExtent, heap_extents()) {}

std::byte* BrickPool::allocate(int capacity) {
  const std::size_t bytes = size_of(capacity);
  std::byte* planes = nullptr;
  {
    const std::lock_guard lock(mutex_);
    std::vector<std::byte*>& free = free_[static_cast<std::size_t>(capacity / kStep - 1)];
    if (free.empty()) {
      planes = cut(bytes);
    } else {
      planes = free.back();
      free.pop_back();
    }
  }
  std::memset(planes, 0, bytes);
  return planes;
}

void BrickPool::give_back(std::byte* planes, int capacity) {
  const std::lock_guard lock(mutex_);
  free_[static_cast<std::size_t>(capacity / kStep - 1)].push_back(planes);
}

std::size_t BrickPool::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::byte* BrickPool::cut(std::size_t bytes) {
  while (left_ < bytes) {
    std::byte* const extent = extents_(extent_bytes_);  // may throw, before anything changed
    if (extent != next_ + left_) {
      if (left_ >= size_of(kStep)) free_[left_ / size_of(kStep) - 1].push_back(next_);
      bytes_ += left_;
      next_ = extent;
      left_ = 0;
    }
    left_ += extent_bytes_;
  }
  left_ -= bytes;
  bytes_ += bytes;
  return std::exchange(next_, next_ + bytes);
}

}  // namespace panoptic
