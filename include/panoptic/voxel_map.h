// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The voxels of a map: blocks in a hash table (Niessner et al. 2013). Blocks never move and are never freed while the map lives,
// so a pointer to one stays good. Under a memory limit, voxels of blocks that were not used for long lie in a file meanwhile; the
// map is the same, bit for bit.
//
// Threads: find and the const functions may run side by side; allocate and mark_changed need the map for themselves.
// Writing voxels of different blocks from different threads is fine.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "panoptic/options.h"
#include "panoptic/voxel_block.h"

namespace panoptic {

// Block (x, y, z) spans [x, x + 1) * 16 voxels on each axis.
struct BlockIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  auto operator<=>(const BlockIndex&) const = default;
};

// Coordinates must fit 21 bits each: +-1,048,575 blocks, 400 km at 2.4 cm.
inline constexpr std::int32_t kMaxBlockCoordinate = (1 << 20) - 1;

constexpr bool in_range(BlockIndex i) {
  const auto fits = [](std::int32_t c) { return c >= -kMaxBlockCoordinate && c <= kMaxBlockCoordinate; };
  return fits(i.x) && fits(i.y) && fits(i.z);
}

// Number of a block within its map: 0, 1, 2 ... in the order of allocation.
using Slot = std::uint32_t;

class BlockPager;
class BrickPool;

class VoxelMap {
 public:
  // Throws Error if there is a memory limit and the swap folder cannot be written.
  explicit VoxelMap(const MapOptions& options);
  VoxelMap(VoxelMap&&) noexcept;
  VoxelMap& operator=(VoxelMap&&) noexcept;
  VoxelMap(const VoxelMap&) = delete;
  VoxelMap& operator=(const VoxelMap&) = delete;
  ~VoxelMap();

  float voxel_size_m() const { return voxel_size_m_; }
  float truncation_m() const { return truncation_m_; }
  float max_weight() const { return max_weight_; }  // infinity: no limit
  float block_size_m() const { return voxel_size_m_ * kBlockSide; }

  std::size_t block_count() const { return blocks_.size(); }
  std::size_t memory_bytes() const;     // index and slack included, without what lies in the file alone
  std::size_t observed_voxels() const;  // W^D > 0
  // nullptr without a memory limit.
  const BlockPager* pager() const { return pager_.get(); }

  // nullptr if the block was never allocated.
  const VoxelBlock* find(BlockIndex index) const;
  static constexpr Slot kNoSlot = ~Slot{0};
  Slot find_slot(BlockIndex index) const;

  VoxelBlock& block(Slot slot) {
    if (pager_) touch(slot);
    return *blocks_[slot];
  }
  const VoxelBlock& block(Slot slot) const {
    if (pager_) touch(slot);
    return *blocks_[slot];
  }
  BlockIndex index_of(Slot slot) const { return indices_[slot]; }

  // The slot of the block, newly made (no voxels, changed in the current epoch) if it was absent. REQUIRES in_range(index).
  // Throws Error if there is a memory limit and no space for the file.
  Slot allocate(BlockIndex index);

  // Epochs instead of dirty flags: every reader keeps the last epoch that it saw (0 at first) and asks for what changed since.
  // begin_epoch starts a new one; mark_changed stamps a block with it.
  std::uint64_t begin_epoch();
  std::uint64_t epoch() const { return epoch_; }
  void mark_changed(Slot slot) { changed_at_[slot] = epoch_; }
  std::uint64_t changed_at(Slot slot) const { return changed_at_[slot]; }
  std::vector<Slot> changed_since(std::uint64_t epoch) const;  // ascending

  // Takes up the epochs of a map that was saved. REQUIRES changed_at per slot, none after `epoch`.
  void restore_epochs(std::uint64_t epoch, std::vector<std::uint64_t> changed_at) {
    epoch_ = epoch;
    changed_at_ = std::move(changed_at);
  }

  // A fingerprint of every voxel bit: equal maps have equal hashes, whatever the order in which blocks were allocated.
  std::uint64_t hash() const;

 private:
  void touch(Slot slot) const;
  void grow_table();
  std::size_t probe(std::uint64_t key) const;

  float voxel_size_m_;
  float truncation_m_;
  float max_weight_;
  std::uint64_t epoch_ = 1;
  std::unique_ptr<BlockPager> pager_;  // has a pool for each block, if there is a memory limit
  std::unique_ptr<BrickPool> pool_;    // of all blocks, if there is none
  std::vector<std::unique_ptr<VoxelBlock>> blocks_;
  std::vector<BlockIndex> indices_;
  std::vector<std::uint64_t> changed_at_;
  std::vector<std::uint64_t> table_keys_;  // open addressing, power of two, key + 1 (0 = free)
  std::vector<Slot> table_slots_;
};

// For every LabelSlot (kLabelSlots entries), whether any voxel holds it.
std::vector<bool> ids_in_use(const VoxelMap& map);

}  // namespace panoptic
