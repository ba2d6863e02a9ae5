// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Voxels that may be more than memory should hold. They lie in a file without a name, mapped into memory: the voxels of a block
// that was not used for long are given back to the file, and come back by themselves when somebody reads or writes them. So a
// pointer to them stays good, and no reader knows about it. docs/decisions/0011 says why it is the operating system's paging.
//
// Threads: touch and what pools do may run in any number of threads at any time; add needs the pager for itself.
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
#include "panoptic/map/brick_pool.h"

namespace panoptic {

class BlockPager {
 public:
  // The limit bounds the voxels in memory, or all that the process has there but its networks. Of a process the rest is
  // measured again and again, and voxels get what it leaves.
  enum class Bounds { kVoxels, kProcess };

  // A file without a name in `folder`: it vanishes with the process, however that ends. No fewer than kFewestBytes of voxels
  // stay in memory, whatever the limit is. Throws Error if there can be no such file.
  BlockPager(std::size_t limit_bytes, const std::filesystem::path& folder, Bounds bounds = Bounds::kVoxels);
  ~BlockPager();
  BlockPager(const BlockPager&) = delete;
  BlockPager& operator=(const BlockPager&) = delete;

  static constexpr std::size_t kFewestBytes = 6 << 20;
  // Kept free in a process for what the next stage takes before it is measured: a tile of the regularizer, say.
  static constexpr std::size_t kHeadroomBytes = 32 << 20;

  std::size_t limit_bytes() const { return limit_bytes_; }
  // The least limit under which the process could be as it is now, with all voxels that it has in memory.
  std::size_t least_limit_bytes() const;

  // The memory for the voxels of the next block. Disk space for all of them is taken at once: a full disk is an Error here, and
  // hardly ever later.
  BrickPool& add();

  // Says that block `slot` is about to be used; gives blocks that were not used for the longest back if there are too many.
  void touch(std::size_t slot) {
    Block& block = block_at(slot);
    const std::uint32_t now = now_.load(std::memory_order_relaxed);
    if (block.used_at.load(std::memory_order_relaxed) == now) return;
    if (block.used_at.exchange(now, std::memory_order_relaxed) == kAway) came_in(block.pages.load(std::memory_order_relaxed));
  }

  // Ends a moment: blocks that are touched from now on count as used later than those touched before.
  void tick();

  std::size_t bytes_in_memory() const { return pages_in_memory_.load(std::memory_order_relaxed) * kPage; }
  std::uint64_t blocks_given_back() const { return given_back_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kPage = 4096;
  // A block all of whose voxels are stored takes 24 pages. The system brings in 16 aligned ones at a time if it can; so that
  // these never belong to two blocks, regions are a multiple of that.
  static constexpr std::size_t kRegionPages = 32;
  static constexpr std::size_t kChunkRegions = 256;
  static constexpr std::size_t kChunkBlocks = 256;
  static constexpr std::size_t kMeasurePages = 128;  // come in between two measurements at most
  static constexpr std::uint32_t kAway = 0;          // in the file alone, as far as touch was told

  struct Block {
    std::atomic<std::uint32_t> used_at{kAway};
    std::atomic<std::size_t> pages{0};
    std::vector<std::byte*> regions;  // all but the last are full
    std::unique_ptr<BrickPool> pool;
  };
  using BlockChunk = std::array<Block, kChunkBlocks>;

  Block& block_at(std::size_t slot) { return (*blocks_[slot / kChunkBlocks])[slot % kChunkBlocks]; }
  std::byte* next_page(Block& block);
  std::byte* next_region();
  void add_chunk();
  void came_in(std::size_t pages);
  std::size_t rest_bytes() const;  // of the process
  void measure();
  void make_room();
  void give_back(Block& block);

  std::filesystem::path folder_;
  std::size_t limit_bytes_;
  Bounds bounds_;
  std::atomic<std::size_t> limit_pages_;  // of voxels
  os::File file_;
  std::size_t count_ = 0;
  std::vector<std::unique_ptr<BlockChunk>> blocks_;
  std::mutex mutex_;                // of regions
  std::vector<std::byte*> chunks_;  // of the file
  std::size_t regions_ = 0;         // given out
  std::size_t regions_beyond_ = 0;  // of them those that are not the first of their block
  std::atomic<std::uint32_t> now_{1};
  std::atomic<std::size_t> pages_in_memory_{0};
  std::atomic<std::size_t> pages_since_measured_{0};
  std::atomic<std::uint64_t> given_back_{0};
  std::mutex making_room_;
};

}  // namespace panoptic
