// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/block_pager.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "panoptic/base/memory.h"
#include "panoptic/error.h"

namespace panoptic {

BlockPager::BlockPager(std::size_t limit_bytes, const std::filesystem::path& folder, Bounds bounds)
    : folder_(folder),
      limit_bytes_(limit_bytes),
      bounds_(bounds),
      limit_pages_(std::max(kFewestBytes, limit_bytes) / kPage),
      file_(os::open_without_name(folder)) {
  if (!file_.is_open()) {
    throw Error(fmt::format("map.memory_limit_mb needs a file in {}: {}; set map.swap_folder to a folder that can be written",
                            folder.string(), os::reason(errno)));
  }
  measure();
}

BlockPager::~BlockPager() {
  for (std::byte* chunk : chunks_) os::unmap(chunk, kChunkRegions * kRegionPages * kPage);
}

BrickPool& BlockPager::add() {
  const std::lock_guard lock(mutex_);
  // Room for the first region of every block, so that none of them fails for want of disk space while a frame is fused.
  while (chunks_.size() * kChunkRegions < count_ + 1 + regions_beyond_) add_chunk();
  if (count_ % kChunkBlocks == 0) blocks_.push_back(std::make_unique<BlockChunk>());
  Block& block = block_at(count_++);
  block.used_at = now_.load(std::memory_order_relaxed);
  block.pool = std::make_unique<BrickPool>(kPage, [this, &block](std::size_t) { return next_page(block); });
  return *block.pool;
}

std::byte* BlockPager::next_page(Block& block) {
  const std::size_t pages = block.pages.load(std::memory_order_relaxed);
  if (pages % kRegionPages == 0) {
    const std::lock_guard lock(mutex_);
    std::byte* const region = next_region();
    if (pages > 0) ++regions_beyond_;
    block.regions.push_back(region);
  }
  block.pages.store(pages + 1, std::memory_order_relaxed);
  came_in(1);
  return block.regions.back() + pages % kRegionPages * kPage;
}

std::byte* BlockPager::next_region() {
  if (regions_ == chunks_.size() * kChunkRegions) add_chunk();
  const std::size_t region = regions_++;
  return chunks_[region / kChunkRegions] + region % kChunkRegions * kRegionPages * kPage;
}

void BlockPager::add_chunk() {
  constexpr std::size_t kBytes = kChunkRegions * kRegionPages * kPage;
  const std::uint64_t begin = chunks_.size() * kBytes;
  if (!file_.take_space(begin, kBytes)) {
    throw Error(fmt::format("no {} MB more for the map in {}: {}; free some space or set map.swap_folder", kBytes >> 20,
                            folder_.string(), os::reason(errno)));
  }
  auto* const chunk = static_cast<std::byte*>(file_.map(begin, kBytes, kRegionPages * kPage));
  if (chunk == nullptr)
    throw Error(fmt::format("the map's file in {} cannot be mapped: {}", folder_.string(), os::reason(errno)));
  chunks_.push_back(chunk);
}

std::size_t BlockPager::rest_bytes() const {
  const std::size_t all = resident_bytes();
  return all - std::min(all, left_out_of_limit() + bytes_in_memory());
}

void BlockPager::measure() {
  if (bounds_ == Bounds::kVoxels) return;
  pages_since_measured_.store(0, std::memory_order_relaxed);
  const std::size_t left = limit_bytes_ - std::min(limit_bytes_, rest_bytes() + kHeadroomBytes);
  limit_pages_.store(std::max(kFewestBytes, left) / kPage, std::memory_order_relaxed);
}

std::size_t BlockPager::least_limit_bytes() const {
  return rest_bytes() + kHeadroomBytes + std::max(kFewestBytes, bytes_in_memory());
}

void BlockPager::tick() {
  now_.fetch_add(1, std::memory_order_relaxed);
  measure();
  if (pages_in_memory_.load(std::memory_order_relaxed) > limit_pages_.load(std::memory_order_relaxed)) make_room();
}

void BlockPager::came_in(std::size_t pages) {
  if (pages_since_measured_.fetch_add(pages, std::memory_order_relaxed) + pages >= kMeasurePages) measure();
  const std::size_t in_memory = pages_in_memory_.fetch_add(pages, std::memory_order_relaxed) + pages;
  if (in_memory > limit_pages_.load(std::memory_order_relaxed)) make_room();
}

// A quarter at a time, so that it is seldom. Whoever comes meanwhile goes on: the limit is overstepped by a few blocks at most.
void BlockPager::make_room() {
  const std::unique_lock lock(making_room_, std::try_to_lock);
  if (!lock) return;
  std::vector<std::pair<std::uint32_t, std::size_t>> here;  // last use, slot
  std::size_t pages = 0;
  for (std::size_t slot = 0; slot < count_; ++slot) {
    const std::uint32_t used_at = block_at(slot).used_at.load(std::memory_order_relaxed);
    if (used_at == kAway) continue;
    pages += block_at(slot).pages.load(std::memory_order_relaxed);
    here.emplace_back(used_at, slot);
  }
  std::sort(here.begin(), here.end());
  const std::size_t limit = limit_pages_.load(std::memory_order_relaxed);
  const std::size_t keep = limit - limit / 4;
  for (const auto& [used_at, slot] : here) {
    if (pages <= keep) break;
    pages -= block_at(slot).pages.load(std::memory_order_relaxed);
    give_back(block_at(slot));
  }
  pages_in_memory_.store(pages, std::memory_order_relaxed);
  now_.fetch_add(1, std::memory_order_relaxed);
}

// Pages of a shared mapping lose nothing by it: what was written is in the file's pages, which the system writes out in its time.
void BlockPager::give_back(Block& block) {
  block.used_at.store(kAway, std::memory_order_relaxed);
  const std::lock_guard lock(mutex_);
  std::size_t pages = block.pages.load(std::memory_order_relaxed);
  for (std::byte* region : block.regions) {
    os::give_back(region, std::min(pages, kRegionPages) * kPage);
    pages -= std::min(pages, kRegionPages);
  }
  given_back_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace panoptic
