// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
// Free space as a whole: in order, merged, and in chunks for files.
#include <algorithm>
#include <bit>
#include <cstring>

#include "panoptic/error.h"
#include "panoptic/free_space.h"
#include "panoptic/map/block_key.h"
#include "panoptic/map/space_cells.h"

namespace panoptic {
namespace {

constexpr std::uint32_t kMaxChunkCoordinate = (kMaxBlockCoordinate + 1) / 4;

// Calls visit(block, cells) for the blocks of a chunk in the order of their numbers.
template <typename Blocks, typename Visit>
void visit_blocks(BlockIndex chunk, std::uint64_t present, const Blocks& blocks, const Visit& visit) {
  std::size_t place = 0;
  for (std::uint64_t rest = present; rest != 0; rest &= rest - 1) {
    visit(block_in(chunk, std::countr_zero(rest)), blocks[place++]);
  }
}

bool is_sound_cell(std::uint32_t cell) {
  if (cell == 0) return true;
  const int evidence = evidence_of(cell);
  if (evidence < -kMostOccupied || evidence > kMostEmpty) return false;
  return evidence > 0 ? empty_tick_of(cell) > 0 : occupied_tick_of(cell) > 0;
}

bool is_sound_doubt(BlockIndex chunk, const std::pair<CellIndex, Doubt>& entry) {
  const auto& [cell, doubt] = entry;
  const std::uint64_t any = doubt.count[0] | doubt.count[1] | doubt.count[2];
  return any != 0 && doubt.seen_from_m.allFinite() && panoptic::chunk_of(block_of(cell)) == chunk;
}

class Fingerprint {
 public:
  void add(std::uint64_t word) { sum_ = mixed(sum_ * 31 + word); }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  std::uint64_t sum() const { return sum_; }

 private:
  std::uint64_t sum_ = 0;
};

// The evidence of two maps. Where they contradict each other, the later one is right.
int merged_evidence(std::uint32_t before, std::uint32_t later) {
  if (before == 0 || later == 0 || space_of(before) != space_of(later)) return evidence_of(later == 0 ? before : later);
  return std::clamp(evidence_of(before) + evidence_of(later), -kMostOccupied, kMostEmpty);
}

}  // namespace

std::vector<const FreeSpaceMap::Chunk*> FreeSpaceMap::ordered() const {
  std::vector<const Chunk*> chunks;
  chunks.reserve(chunks_.size());
  for (const Chunk& chunk : chunks_) chunks.push_back(&chunk);
  std::sort(chunks.begin(), chunks.end(), [](const Chunk* a, const Chunk* b) { return pack(a->index) < pack(b->index); });
  return chunks;
}

void FreeSpaceMap::for_each(const std::function<void(const CellIndex&, Space)>& visit) const {
  for (const Chunk* chunk : ordered()) {
    visit_blocks(chunk->index, chunk->present, chunk->blocks, [&](BlockIndex block, const SpaceChunk::Cells& cells) {
      for (int n = 0; n < kBlockCells; ++n) {
        const Space space = space_of(cells[static_cast<std::size_t>(n)]);
        if (space != Space::kUnknown) visit(cell_of(block, n), space);
      }
    });
  }
}

std::optional<std::pair<CellIndex, CellIndex>> FreeSpaceMap::bounds() const {
  std::optional<std::pair<CellIndex, CellIndex>> bounds;
  for_each([&](const CellIndex& cell, Space) {
    if (!bounds) bounds = {cell, cell};
    for (std::size_t a = 0; a < 3; ++a) {
      bounds->first[a] = std::min(bounds->first[a], cell[a]);
      bounds->second[a] = std::max(bounds->second[a], cell[a]);
    }
  });
  return bounds;
}

std::uint64_t FreeSpaceMap::hash() const {
  Fingerprint print;
  if (last_view_) {
    for (int a = 0; a < 3; ++a) print.add(last_view_->camera_m[a]);
    for (int a = 0; a < 3; ++a) print.add(last_view_->axis[a]);
    print.add(last_view_->time);
  }
  print.add(static_cast<std::uint64_t>(log2_));
  for (const Chunk* chunk : ordered()) {
    visit_blocks(chunk->index, chunk->present, chunk->blocks, [&](BlockIndex block, const SpaceChunk::Cells& cells) {
      print.add(pack(block));
      for (const std::uint32_t cell : cells) print.add(std::uint64_t{cell});
    });
  }
  for (const auto& [cell, doubt] : doubts_) {
    print.add(pack(block_of(cell)));
    print.add(static_cast<std::uint64_t>(number_of(cell)));
    for (const std::uint64_t plane : doubt.count) print.add(plane);
    for (int a = 0; a < 3; ++a) print.add(double{doubt.seen_from_m[a]});
  }
  return print.sum();
}

void FreeSpaceMap::merge(const FreeSpaceMap& later) {
  PANOPTIC_ASSERT(later.cell_size_m() == cell_size_m());
  doubts_.clear();
  doubted_.clear();
  if (later.empty()) return;
  const std::uint64_t shift = last_view_ ? last_view_->time + 1 : 0;
  SpaceView view = *later.last_view_;
  view.time += shift;
  begin_view(view, epoch_);
  const auto tick = [&](std::uint32_t theirs) {
    const std::uint64_t time = (std::uint64_t{theirs} - 1) << later.log2_;
    return theirs == 0 ? 0 : static_cast<std::uint32_t>((time + shift) >> log2_) + 1;
  };
  for (const Chunk* chunk : later.ordered()) {
    visit_blocks(chunk->index, chunk->present, chunk->blocks, [&](BlockIndex block, const SpaceChunk::Cells& theirs) {
      SpaceChunk::Cells& ours = cells(block);
      for (std::size_t n = 0; n < ours.size(); ++n) {
        const std::uint32_t empty = tick(empty_tick_of(theirs[n]));
        const std::uint32_t occupied = tick(occupied_tick_of(theirs[n]));
        ours[n] = cell_with(merged_evidence(ours[n], theirs[n]), empty > 0 ? empty : empty_tick_of(ours[n]),
                            occupied > 0 ? occupied : occupied_tick_of(ours[n]));
      }
    });
  }
}

std::vector<SpaceChunk> FreeSpaceMap::changed_since(std::uint64_t epoch) const {
  std::vector<SpaceChunk> changed;
  std::unordered_map<std::uint64_t, std::size_t> place_of;
  for (const Chunk* chunk : ordered()) {
    if (chunk->changed_at <= epoch) continue;
    place_of[pack(chunk->index)] = changed.size();
    changed.push_back({chunk->index, chunk->present, chunk->blocks, {}});
  }
  for (const auto& entry : doubts_) {
    const auto found = place_of.find(pack(panoptic::chunk_of(block_of(entry.first))));
    if (found != place_of.end()) changed[found->second].doubts.emplace_back(entry);
  }
  return changed;
}

void FreeSpaceMap::put(const SpaceChunk& chunk) {
  PANOPTIC_ASSERT(is_sound(chunk) && !chunk_at_.contains(pack(chunk.index)));
  Chunk& kept = chunk_of(block_in(chunk.index, 0));
  kept.present = chunk.present;
  kept.blocks = chunk.blocks;
  for (const auto& [cell, doubt] : chunk.doubts) set_doubt(cell, doubt);
}

void FreeSpaceMap::restore_view(const SpaceView& view, int log2_frames_per_tick) {
  last_view_ = view;
  log2_ = log2_frames_per_tick;
}

bool FreeSpaceMap::is_sound(const SpaceChunk& chunk) {
  constexpr auto kMost = static_cast<std::int32_t>(kMaxChunkCoordinate);
  const auto fits = [](std::int32_t c) { return c > -kMost && c < kMost; };
  if (!fits(chunk.index.x) || !fits(chunk.index.y) || !fits(chunk.index.z)) return false;
  if (chunk.blocks.size() != static_cast<std::size_t>(std::popcount(chunk.present))) return false;
  const bool cells_sound = std::all_of(chunk.blocks.begin(), chunk.blocks.end(), [](const SpaceChunk::Cells& cells) {
    return std::all_of(cells.begin(), cells.end(), is_sound_cell);
  });
  return cells_sound &&
         std::all_of(chunk.doubts.begin(), chunk.doubts.end(),
                     [&](const auto& entry) { return is_sound_doubt(chunk.index, entry); }) &&
         std::is_sorted(chunk.doubts.begin(), chunk.doubts.end(),
                        [](const auto& a, const auto& b) { return a.first <= b.first; });
}

}  // namespace panoptic
