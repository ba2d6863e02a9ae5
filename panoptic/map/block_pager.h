// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Voxel blocks that may be more than memory should hold. They lie in a file without a name, mapped into memory: a block that was
// not used for long is given back to the file, and comes back by itself when somebody reads or writes it. So a pointer to a block
// stays good, and no reader knows about it. docs/decisions/0011 says why it is the operating system's paging.
//
// Threads: touch may be called by any number of threads at any time; add needs the pager for itself.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <vector>

#include "panoptic/base/os.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

class BlockPager {
 public:
  // A file without a name in `folder`: it vanishes with the process, however that ends. At most `limit_bytes` of blocks stay in
  // memory, and no fewer than kFewestBlocks. Throws Error if there can be no such file.
  BlockPager(std::size_t limit_bytes, const std::filesystem::path& folder);
  ~BlockPager();
  BlockPager(const BlockPager&) = delete;
  BlockPager& operator=(const BlockPager&) = delete;

  static constexpr std::size_t kFewestBlocks = 64;

  // The next block, all zero. The disk space for it is taken at once: a full disk is an Error here and never a crash later.
  VoxelBlock* add();

  // Says that block `slot` is about to be used; gives blocks that were not used for the longest back if there are too many.
  void touch(std::size_t slot) {
    std::atomic<std::uint32_t>& used_at = chunks_[slot / kChunkBlocks]->used_at[slot % kChunkBlocks];
    const std::uint32_t now = now_.load(std::memory_order_relaxed);
    if (used_at.load(std::memory_order_relaxed) == now) return;
    if (used_at.exchange(now, std::memory_order_relaxed) != kAway) return;
    if (in_memory_.fetch_add(1, std::memory_order_relaxed) >= limit_) make_room();
  }

  // Ends a moment: blocks that are touched from now on count as used later than those touched before.
  void tick() { now_.fetch_add(1, std::memory_order_relaxed); }

  std::size_t blocks_in_memory() const { return in_memory_.load(std::memory_order_relaxed); }
  std::uint64_t blocks_given_back() const { return given_back_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kChunkBlocks = 256;  // 20 MiB of file at a time
  static constexpr std::uint32_t kAway = 0;         // in the file alone, as far as touch was told

  struct Chunk {
    VoxelBlock* blocks = nullptr;
    std::array<std::atomic<std::uint32_t>, kChunkBlocks> used_at{};
  };

  void add_chunk();
  void make_room();
  void give_back(const std::vector<std::size_t>& slots);

  std::filesystem::path folder_;
  std::size_t limit_;  // blocks
  os::File file_;
  std::size_t count_ = 0;
  std::vector<std::unique_ptr<Chunk>> chunks_;
  std::atomic<std::uint32_t> now_{1};
  std::atomic<std::size_t> in_memory_{0};
  std::atomic<std::uint64_t> given_back_{0};
  std::mutex making_room_;
};

}  // namespace panoptic
