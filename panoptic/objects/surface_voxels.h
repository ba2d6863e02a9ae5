// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The voxels at the surface with their labels and neighbours, which object maintenance looks at.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <bitset>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/error.h"
#include "panoptic/labels.h"
#include "panoptic/map/frame_votes.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

struct SurfaceVoxel {
  std::array<std::int32_t, 3> at{};  // voxel coordinates in the whole map; metres = (at + 0.5) * voxel size
  LabelSlot label = LabelSlot::kUnknown;
  Slot slot = 0;
  std::uint16_t voxel = 0;
};

// Indices of surface voxels, ascending.
using VoxelsByLabel = std::map<LabelSlot, std::vector<std::uint32_t>>;

// The slots of a block and of those around it, x fastest, the block itself in the middle; VoxelMap::kNoSlot where there is none.
using NeighbourSlots = std::array<Slot, kNeighbours>;

// Visits the rows of voxels around the voxel of a block with these neighbours: calls visit(slot, row, mask) with a bit for
// every place that is at most `reach` voxels away along y and z and half_width(dy, dz) (at most reach; none if negative) along
// x, until a call returns false. REQUIRES reach < kBlockSide.
template <typename HalfWidth, typename Visit>
void visit_rows_around(const NeighbourSlots& blocks, std::uint16_t voxel, int reach, HalfWidth&& half_width, Visit&& visit);

// A set of labels that may hold more than were put in: label n is bit n % 256.
using LabelBits = std::bitset<256>;
inline void add_to(LabelBits& bits, std::uint16_t label) { bits.set(label % 256U); }

// The voxels of the surface band, in the order of slots and voxels. A snapshot: relabel changes it, and write_labels brings
// that into the map. Good until blocks are allocated or distances change; then update it.
class SurfaceVoxels {
 public:
  SurfaceVoxels() = default;
  explicit SurfaceVoxels(const VoxelMap& map) { update(map); }

  // Brings it up to date, as if it were made anew. Fast for the map of the last time: blocks that were not marked as changed
  // since are not read again. Labels that were changed must have been written to that map.
  void update(const VoxelMap& map);

  std::size_t size() const { return voxels_.size(); }
  SurfaceVoxel operator[](std::uint32_t i) const;
  std::pair<Slot, std::uint16_t> place_of(std::uint32_t i) const { return {voxels_[i].slot, voxels_[i].voxel}; }
  LabelSlot label(std::uint32_t i) const { return voxels_[i].label; }
  void relabel(std::uint32_t i, LabelSlot label);  // voxels of different blocks also from different threads

  std::size_t block_count() const { return blocks_.size(); }
  std::array<std::int32_t, 3> corner_of(Slot slot) const { return blocks_[slot].corner; }  // its lowest voxel, as `at`
  // The first surface voxel of a block and one past its last.
  std::pair<std::uint32_t, std::uint32_t> range_of(Slot slot) const { return {first_of_slot_[slot], first_of_slot_[slot + 1]}; }

  const NeighbourSlots& neighbours_of(Slot slot) const { return blocks_[slot].neighbours; }

  // Bits of every label that the map holds in this block, surface or not; seldom of others.
  const LabelBits& label_bits(Slot slot) const { return blocks_[slot].label_bits; }
  // Notes that the map's labels were renamed and the block may hold these as well.
  void add_label_bits(Slot slot, const LabelBits& bits) { blocks_[slot].label_bits |= bits; }

  VoxelsByLabel by_label() const;
  // Surface voxels of the labels that `wanted` accepts; it is asked once for every label of the surface, in ascending order.
  VoxelsByLabel by_label(const std::function<bool(LabelSlot)>& wanted) const;

  // Calls visit(index) for every surface voxel at most `reach` (below 16) voxels from this one along each axis, itself included.
  template <typename Visit>
  void visit_near(std::uint32_t i, int reach, Visit&& visit) const;

  // Calls visit_rows_around for this voxel.
  template <typename HalfWidth, typename Visit>
  void visit_rows(std::uint32_t i, int reach, HalfWidth&& half_width, Visit&& visit) const {
    visit_rows_around(blocks_[voxels_[i].slot].neighbours, voxels_[i].voxel, reach, half_width, visit);
  }

  // Connected components of the given voxels, each ascending, the one with the lowest index first. Voxels are connected if they
  // are at most `reach` (below 16) apart along each axis.
  std::vector<std::vector<std::uint32_t>> components(std::span<const std::uint32_t> members, int reach) const;

  // Writes labels that differ from the map's, as decisions that replace frames' votes (FrameVotes::decide). Returns how many.
  std::size_t write_labels(VoxelMap& map, FrameVotes& votes) const;

 private:
  struct Entry {
    Slot slot;
    std::uint16_t voxel;
    LabelSlot label;
  };
  struct Block {
    std::array<std::int32_t, 3> corner{};
    NeighbourSlots neighbours{};
    BlockBits surface{};
    BlockBits before{};  // by row: surface voxels in the rows before it
    std::uint32_t count = 0;
    LabelBits label_bits;
  };

  void meet_new_blocks(const VoxelMap& map);
  void collect(const VoxelMap& map, const std::vector<char>& is_known);
  // The index of the surface voxel at this place. REQUIRES that there is one.
  std::uint32_t index_at(Slot slot, int row, int x) const;

  const VoxelMap* map_ = nullptr;  // the one of the last update, to tell another one; never read
  std::uint64_t seen_epoch_ = 0;
  std::vector<Block> blocks_;  // by slot
  std::vector<Entry> voxels_;
  std::vector<std::uint32_t> first_of_slot_;  // by slot, and one past the end
  std::vector<char> relabelled_;              // by slot
};

// A set of surface voxels, or of the cells that they lie in (CellGrid), that takes memory only for the blocks that it has any in.
class VoxelSet {
 public:
  template <typename Grid>
  VoxelSet(const Grid& grid, std::span<const std::uint32_t> members);

  std::uint16_t bits(Slot slot, int row) const { return blocks_[place_[slot]][static_cast<std::size_t>(row)]; }
  // Takes these out of the set. REQUIRES that they are in.
  void remove(Slot slot, int row, std::uint16_t bits) {
    std::uint16_t& all = blocks_[place_[slot]][static_cast<std::size_t>(row)];
    all = static_cast<std::uint16_t>(all & ~bits);
  }

 private:
  std::vector<std::uint32_t> place_;  // by slot: in blocks_, whose first is empty and stays so
  std::vector<BlockBits> blocks_;
};

template <typename Grid>
VoxelSet::VoxelSet(const Grid& grid, std::span<const std::uint32_t> members) : place_(grid.block_count(), 0), blocks_(1) {
  for (const std::uint32_t member : members) {
    const auto [slot, voxel] = grid.place_of(member);
    if (place_[slot] == 0) {
      place_[slot] = static_cast<std::uint32_t>(blocks_.size());
      blocks_.emplace_back();
    }
    std::uint16_t& row = blocks_[place_[slot]][voxel / kBlockSide];
    row = static_cast<std::uint16_t>(row | 1U << (voxel % kBlockSide));
  }
}

template <typename HalfWidth, typename Visit>
void visit_rows_around(const NeighbourSlots& blocks, std::uint16_t voxel, int reach, HalfWidth&& half_width, Visit&& visit) {
  PANOPTIC_ASSERT(reach >= 0 && reach < kBlockSide);
  // Counted from the corner of the lowest neighbour, so that nothing is negative.
  const int cx = kBlockSide + voxel % kBlockSide;
  const int cy = kBlockSide + voxel / kBlockSide % kBlockSide;
  const int cz = kBlockSide + voxel / (kBlockSide * kBlockSide);
  for (int z = cz - reach; z <= cz + reach; ++z) {
    for (int y = cy - reach; y <= cy + reach; ++y) {
      const int width = half_width(y - cy, z - cz);
      if (width < 0) continue;
      const std::uint64_t mask = ((std::uint64_t{2} << (2 * width)) - 1) << (cx - width);
      const int row = y % kBlockSide + kBlockSide * (z % kBlockSide);
      const int first = 3 * (y / kBlockSide + 3 * (z / kBlockSide));
      for (int bx = (cx - width) / kBlockSide; bx <= (cx + width) / kBlockSide; ++bx) {
        const Slot slot = blocks[static_cast<std::size_t>(first + bx)];
        if (slot == VoxelMap::kNoSlot) continue;
        if (!visit(slot, row, static_cast<std::uint16_t>(mask >> (bx * kBlockSide)))) return;
      }
    }
  }
}

inline SurfaceVoxel SurfaceVoxels::operator[](std::uint32_t i) const {
  const Entry& e = voxels_[i];
  return {voxel_at(blocks_[e.slot].corner, e.voxel), e.label, e.slot, e.voxel};
}

inline std::uint32_t SurfaceVoxels::index_at(Slot slot, int row, int x) const {
  const Block& block = blocks_[slot];
  const auto r = static_cast<std::size_t>(row);
  const unsigned lower = block.surface[r] & ((1U << x) - 1);
  return first_of_slot_[slot] + block.before[r] + static_cast<std::uint32_t>(std::popcount(lower));
}

template <typename Visit>
void SurfaceVoxels::visit_near(std::uint32_t i, int reach, Visit&& visit) const {
  const auto same = [reach](int, int) { return reach; };
  visit_rows(i, reach, same, [&](Slot slot, int row, std::uint16_t mask) {
    const unsigned bits = blocks_[slot].surface[static_cast<std::size_t>(row)] & unsigned{mask};
    if (bits == 0) return true;
    const std::uint32_t first = index_at(slot, row, std::countr_zero(bits));
    // The mask has no gaps, so what it shows of a row is consecutive.
    for (int n = 0; n < std::popcount(bits); ++n) visit(first + static_cast<std::uint32_t>(n));
    return true;
  });
}

}  // namespace panoptic
