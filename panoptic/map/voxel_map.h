// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The map: voxel blocks in a hash table (Niessner et al. 2013). Blocks are aligned, never move and are never freed while the
// map lives, so a pointer stays good. Under a memory limit, blocks that were not used for long lie in a file meanwhile
// (block_pager.h); the map is the same, bit for bit.
//
// Threads: find and the const functions may run side by side; allocate and mark_changed need the map for themselves.
// Writing voxels of different blocks from different threads is fine; the map takes no lock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/base/geometry.h"
#include "panoptic/map/block_index.h"
#include "panoptic/map/block_pager.h"
#include "panoptic/map/voxel_block.h"

namespace panoptic {

struct MapOptions {
  float voxel_size_m = 0.024F;
  float truncation_voxels = 4;  // half width of the band in which voxels are updated
  // Most that W^D and W^V of a voxel may come to; 0 = no limit. From there on old frames fade, and a surface, colour or label
  // that is seen anew outweighs all before it after ln 2 * max_weight / w frames, where w = 1/z^2 (for labels times the vote):
  // 6,900 frames at 1 m, 620 at 0.3 m, 170,000 at 5 m; colours win no later. Rays count a voxel once each.
  float max_weight = 10000;
  int memory_limit_mb = 0;  // of 1e6 bytes; 0 = none
  std::string swap_folder;  // of the file that holds what is beyond the limit; empty = the system's for temporary files
};
Fields fields(MapOptions& options);
Fields grid_fields(MapOptions& options);  // those that decide what the map is: not where it lies

// Number of a block within its map: 0, 1, 2 ... in the order of allocation.
using Slot = std::uint32_t;

class VoxelMap {
 public:
  // Throws Error if there is a memory limit and the swap folder cannot be written.
  explicit VoxelMap(const MapOptions& options);

  float voxel_size_m() const { return voxel_size_m_; }
  float truncation_m() const { return truncation_m_; }
  float max_weight() const { return max_weight_; }  // infinity: no limit
  float block_size_m() const { return voxel_size_m_ * kBlockSide; }

  std::size_t block_count() const { return blocks_.size(); }
  std::size_t memory_bytes() const;  // without what lies in the file alone
  // nullptr without a memory limit.
  const BlockPager* pager() const { return pager_.get(); }

  // nullptr if the block was never allocated.
  const VoxelBlock* find(BlockIndex index) const;
  static constexpr Slot kNoSlot = ~Slot{0};
  Slot find_slot(BlockIndex index) const;

  VoxelBlock& block(Slot slot) {
    if (pager_) pager_->touch(slot);
    return *blocks_[slot];
  }
  const VoxelBlock& block(Slot slot) const {
    if (pager_) pager_->touch(slot);
    return *blocks_[slot];
  }
  BlockIndex index_of(Slot slot) const { return indices_[slot]; }

  // The slot of the block, newly made (all zero, changed in the current epoch) if it was absent. REQUIRES in_range(index).
  // Throws Error if there is a memory limit and no space for the file.
  Slot allocate(BlockIndex index);

  // Epochs instead of dirty flags: every reader keeps the last epoch that it saw (0 at first) and asks for what changed since.
  // begin_epoch starts a new one; mark_changed stamps a block with it.
  std::uint64_t begin_epoch() {
    if (pager_) pager_->tick();
    return ++epoch_;
  }
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
  void grow_table();
  std::size_t probe(std::uint64_t key) const;

  float voxel_size_m_;
  float truncation_m_;
  float max_weight_;
  std::uint64_t epoch_ = 1;
  std::unique_ptr<BlockPager> pager_;                 // owns the blocks, if there is a memory limit
  std::vector<std::unique_ptr<VoxelBlock>> in_heap_;  // else
  std::vector<VoxelBlock*> blocks_;
  std::vector<BlockIndex> indices_;
  std::vector<std::uint64_t> changed_at_;
  std::vector<std::uint64_t> table_keys_;  // open addressing, power of two, key + 1 (0 = free)
  std::vector<Slot> table_slots_;
};

// By LabelSlot (kLabelSlots entries): does any voxel hold it?
std::vector<bool> ids_in_use(const VoxelMap& map);

// Looks up voxels near the previous one without hashing again. One per thread; make a new one after blocks were allocated.
class CachedLookup {
 public:
  explicit CachedLookup(const VoxelMap& map) : map_(map) {}

  const VoxelBlock* find(BlockIndex index) {
    if (!valid_ || index != last_) {
      block_ = map_.find(index);
      last_ = index;
      valid_ = true;
    }
    return block_;
  }

 private:
  const VoxelMap& map_;
  BlockIndex last_;
  const VoxelBlock* block_ = nullptr;
  bool valid_ = false;
};

}  // namespace panoptic
