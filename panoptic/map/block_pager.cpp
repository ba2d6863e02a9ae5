// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/block_pager.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <new>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {

BlockPager::BlockPager(std::size_t limit_bytes, const std::filesystem::path& folder)
    : folder_(folder), limit_(std::max(kFewestBlocks, limit_bytes / sizeof(VoxelBlock))), file_(os::open_without_name(folder)) {
  if (!file_.is_open()) {
    throw Error(fmt::format("map.memory_limit_mb needs a file in {}: {}; set map.swap_folder to a folder that can be written",
                            folder.string(), os::reason(errno)));
  }
}

BlockPager::~BlockPager() {
  for (const auto& chunk : chunks_) os::unmap(chunk->blocks, kChunkBlocks * sizeof(VoxelBlock));
}

VoxelBlock* BlockPager::add() {
  if (count_ % kChunkBlocks == 0) add_chunk();
  const std::size_t slot = count_++;
  touch(slot);
  return new (&chunks_.back()->blocks[slot % kChunkBlocks]) VoxelBlock;
}

void BlockPager::add_chunk() {
  constexpr std::size_t kBytes = kChunkBlocks * sizeof(VoxelBlock);
  const std::uint64_t begin = chunks_.size() * kBytes;
  if (!file_.take_space(begin, kBytes)) {
    throw Error(fmt::format("no {} MB more for the map in {}: {}; free some space or set map.swap_folder", kBytes >> 20,
                            folder_.string(), os::reason(errno)));
  }
  auto chunk = std::make_unique<Chunk>();
  chunk->blocks = static_cast<VoxelBlock*>(file_.map(begin, kBytes));
  if (chunk->blocks == nullptr)
    throw Error(fmt::format("the map's file in {} cannot be mapped: {}", folder_.string(), os::reason(errno)));
  chunks_.push_back(std::move(chunk));
}

// A quarter at a time, so that it is seldom. Whoever comes meanwhile goes on: the limit is overstepped by a few blocks at most.
void BlockPager::make_room() {
  const std::unique_lock lock(making_room_, std::try_to_lock);
  if (!lock) return;
  std::vector<std::pair<std::uint32_t, std::size_t>> here;  // last use, slot
  for (std::size_t slot = 0; slot < chunks_.size() * kChunkBlocks; ++slot) {
    const std::uint32_t used_at = chunks_[slot / kChunkBlocks]->used_at[slot % kChunkBlocks].load(std::memory_order_relaxed);
    if (used_at != kAway) here.emplace_back(used_at, slot);
  }
  const std::size_t keep = limit_ - limit_ / 4;
  if (here.size() <= keep) return;
  const auto end = here.begin() + static_cast<std::ptrdiff_t>(here.size() - keep);
  std::nth_element(here.begin(), end, here.end());
  std::vector<std::size_t> slots;
  for (auto h = here.begin(); h != end; ++h) slots.push_back(h->second);
  std::sort(slots.begin(), slots.end());
  give_back(slots);
  tick();
}

// Pages of a shared mapping lose nothing by it: what was written is in the file's pages, which the system writes out in its time.
void BlockPager::give_back(const std::vector<std::size_t>& slots) {
  for (std::size_t begin = 0; begin < slots.size();) {
    std::size_t end = begin + 1;
    while (end < slots.size() && slots[end] == slots[end - 1] + 1 && slots[end] % kChunkBlocks != 0) ++end;
    Chunk& chunk = *chunks_[slots[begin] / kChunkBlocks];
    const std::size_t first = slots[begin] % kChunkBlocks;
    for (std::size_t i = first; i < first + end - begin; ++i) chunk.used_at[i].store(kAway, std::memory_order_relaxed);
    os::give_back(&chunk.blocks[first], (end - begin) * sizeof(VoxelBlock));
    begin = end;
  }
  in_memory_.fetch_sub(slots.size(), std::memory_order_relaxed);
  given_back_.fetch_add(slots.size(), std::memory_order_relaxed);
}

}  // namespace panoptic
