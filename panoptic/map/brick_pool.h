// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Memory for bricks: pieces for 8, 16 ... 64 voxels, cut from large extents; what is given back is given out again.
//
// Threads: all functions may be called from any number of threads.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <mutex>
#include <vector>

#include "panoptic/voxel_block.h"

namespace panoptic {

class BrickPool {
 public:
  // Returns that many bytes, a multiple of 64 and aligned to it, which stay until the pool is no more. May throw Error.
  using Extents = std::function<std::byte*(std::size_t bytes)>;
  BrickPool(std::size_t extent_bytes, Extents extents) : extent_bytes_(extent_bytes), extents_(std::move(extents)) {}
  // Extents on the heap.
  BrickPool();

  // All zero. REQUIRES a capacity of 8, 16 ... 64 voxels.
  std::byte* allocate(int capacity);
  void give_back(std::byte* planes, int capacity);

  // All that was ever cut from extents, in use or to be given out again.
  std::size_t bytes() const;

 private:
  static constexpr int kStep = 8;
  static std::size_t size_of(int capacity) { return static_cast<std::size_t>(capacity) * kVoxelBytes; }

  std::byte* cut(std::size_t bytes);

  mutable std::mutex mutex_;
  std::size_t extent_bytes_;
  Extents extents_;
  std::byte* next_ = nullptr;
  std::size_t left_ = 0;  // of the last extent
  std::size_t bytes_ = 0;
  std::array<std::vector<std::byte*>, kBrickVoxels / kStep> free_;
};

}  // namespace panoptic
