// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/free_space.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "panoptic/error.h"
#include "panoptic/map/block_key.h"
#include "panoptic/map/space_cells.h"

namespace panoptic {
namespace {

// Chunks take memory for so many blocks at a time.
constexpr std::size_t kBlocksMore = 8;

std::uint64_t bit(int number) { return std::uint64_t{1} << number; }

bool reached(const CellIndex& cell) { return in_range(block_of(cell)); }

}  // namespace

std::size_t FreeSpaceMap::Chunk::place(int block) const {
  return static_cast<std::size_t>(std::popcount(present & (bit(block) - 1)));
}

const FreeSpaceMap::Chunk* FreeSpaceMap::find(BlockIndex block) const {
  const auto found = chunk_at_.find(pack(panoptic::chunk_of(block)));
  return found == chunk_at_.end() ? nullptr : &chunks_[found->second];
}

// Made if there was none, and stamped with the current epoch.
FreeSpaceMap::Chunk& FreeSpaceMap::chunk_of(BlockIndex block) {
  PANOPTIC_ASSERT(in_range(block));
  const BlockIndex index = panoptic::chunk_of(block);
  const auto [at, is_new] = chunk_at_.try_emplace(pack(index), static_cast<std::uint32_t>(chunks_.size()));
  if (is_new) chunks_.push_back({.index = index, .present = 0, .changed_at = 0, .blocks = {}});
  Chunk& chunk = chunks_[at->second];
  chunk.changed_at = epoch_;
  return chunk;
}

const SpaceChunk::Cells* FreeSpaceMap::cells_of(BlockIndex block) const {
  const Chunk* chunk = find(block);
  if (chunk == nullptr || (chunk->present & bit(number_of(block))) == 0) return nullptr;
  return &chunk->blocks[chunk->place(number_of(block))];
}

// Made, all unknown, if they were not there.
SpaceChunk::Cells& FreeSpaceMap::cells(BlockIndex block) {
  Chunk& chunk = chunk_of(block);
  const int number = number_of(block);
  const std::size_t place = chunk.place(number);
  if ((chunk.present & bit(number)) == 0) {
    if (chunk.blocks.size() == chunk.blocks.capacity()) chunk.blocks.reserve(chunk.blocks.size() + kBlocksMore);
    chunk.blocks.insert(chunk.blocks.begin() + static_cast<std::ptrdiff_t>(place), SpaceChunk::Cells{});
    chunk.present |= bit(number);
  }
  return chunk.blocks[place];
}

Space FreeSpaceMap::at(const CellIndex& cell) const {
  if (!reached(cell)) return Space::kUnknown;
  const SpaceChunk::Cells* cells = cells_of(block_of(cell));
  return cells == nullptr ? Space::kUnknown : space_of((*cells)[static_cast<std::size_t>(number_of(cell))]);
}

CellRecord FreeSpaceMap::record(const CellIndex& cell) const {
  if (!reached(cell)) return {};
  const SpaceChunk::Cells* cells = cells_of(block_of(cell));
  if (cells == nullptr) return {};
  const std::uint32_t bits = (*cells)[static_cast<std::size_t>(number_of(cell))];
  CellRecord record{.evidence = evidence_of(bits), .empty_at = {}, .occupied_at = {}};
  if (const std::uint64_t tick = empty_tick_of(bits); tick > 0) record.empty_at = (tick - 1) << log2_;
  if (const std::uint64_t tick = occupied_tick_of(bits); tick > 0) record.occupied_at = (tick - 1) << log2_;
  return record;
}

std::optional<CellIndex> FreeSpaceMap::cell_around(const Vec3d& point_m) const {
  const Vec3d cell = (point_m / double{cell_size_m_}).array().floor();
  constexpr double kFarthest = 4.0 * kMaxBlockCoordinate;
  if (!cell.allFinite() || cell.cwiseAbs().maxCoeff() > kFarthest) return std::nullopt;
  return CellIndex{static_cast<std::int32_t>(cell.x()), static_cast<std::int32_t>(cell.y()), static_cast<std::int32_t>(cell.z())};
}

void FreeSpaceMap::halve_times() {
  ++log2_;
  for (Chunk& chunk : chunks_) {
    chunk.changed_at = epoch_;
    for (SpaceChunk::Cells& cells : chunk.blocks) std::transform(cells.begin(), cells.end(), cells.begin(), with_halved_times);
  }
}

void FreeSpaceMap::begin_view(const SpaceView& view, std::uint64_t epoch) {
  PANOPTIC_ASSERT(!last_view_ || view.time >= last_view_->time);
  last_view_ = view;
  epoch_ = epoch;
  while ((view.time >> log2_) >= kMostTicks) halve_times();
}

void FreeSpaceMap::observe(BlockIndex block, std::uint64_t empty, std::uint64_t occupied) {
  PANOPTIC_ASSERT((empty & occupied) == 0 && last_view_);
  if ((empty | occupied) == 0) return;
  const auto tick = static_cast<std::uint32_t>(last_view_->time >> log2_) + 1;
  SpaceChunk::Cells& seen = cells(block);
  for (std::uint64_t rest = empty; rest != 0; rest &= rest - 1) {
    std::uint32_t& cell = seen[static_cast<std::size_t>(std::countr_zero(rest))];
    cell = seen_empty(cell, tick);
  }
  for (std::uint64_t rest = occupied; rest != 0; rest &= rest - 1) {
    std::uint32_t& cell = seen[static_cast<std::size_t>(std::countr_zero(rest))];
    cell = seen_occupied(cell, tick);
  }
}

const Doubt* FreeSpaceMap::doubt(const CellIndex& cell) const {
  const auto found = doubts_.find(cell);
  return found == doubts_.end() ? nullptr : &found->second;
}

std::uint64_t FreeSpaceMap::doubted(BlockIndex block) const {
  const auto found = doubted_.find(pack(block));
  return found == doubted_.end() ? 0 : found->second;
}

void FreeSpaceMap::set_doubt(const CellIndex& cell, const Doubt& doubt) {
  chunk_of(block_of(cell));  // it changes
  doubts_[cell] = doubt;
  doubted_[pack(block_of(cell))] |= bit(number_of(cell));
}

void FreeSpaceMap::drop_doubt(const CellIndex& cell) {
  if (doubts_.erase(cell) == 0) return;
  chunk_of(block_of(cell));
  const auto of_block = doubted_.find(pack(block_of(cell)));
  of_block->second &= ~bit(number_of(cell));
  if (of_block->second == 0) doubted_.erase(of_block);
}

std::size_t FreeSpaceMap::memory_bytes() const {
  constexpr std::size_t kPerEntry = 4 * sizeof(void*);  // of a hash table or a tree, beside what it holds
  std::size_t bytes = chunks_.capacity() * sizeof(Chunk) + chunk_at_.size() * (kPerEntry + 16) +
                      doubted_.size() * (kPerEntry + 16) + doubts_.size() * (kPerEntry + sizeof(CellIndex) + sizeof(Doubt));
  for (const Chunk& chunk : chunks_) bytes += chunk.blocks.capacity() * sizeof(SpaceChunk::Cells);
  return bytes;
}

}  // namespace panoptic
