// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The voxels at the surface with their labels and neighbours: what object maintenance looks at.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "panoptic/data/labels.h"
#include "panoptic/map/voxel_map.h"

namespace panoptic {

struct SurfaceVoxel {
  std::array<std::int32_t, 3> at{};  // voxel coordinates in the whole map; metres = (at + 0.5) * voxel size
  PanopticId label = PanopticId::kUnknown;
  Slot slot = 0;
  std::uint16_t voxel = 0;
};

// Indices of surface voxels, ascending.
using VoxelsByLabel = std::map<PanopticId, std::vector<std::uint32_t>>;

// All observed voxels within 1.5 voxels of the surface, in the order of slots and voxels. A snapshot: relabel changes it, and
// write_labels brings that into the map. Good until blocks are allocated or distances change.
class SurfaceVoxels {
 public:
  explicit SurfaceVoxels(const VoxelMap& map);

  std::size_t size() const { return voxels_.size(); }
  const SurfaceVoxel& operator[](std::uint32_t i) const { return voxels_[i]; }
  void relabel(std::uint32_t i, PanopticId label) { voxels_[i].label = label; }

  VoxelsByLabel by_label() const;

  // Calls visit(index) for every surface voxel at most `reach` (below 16) voxels from this one along each axis, itself included.
  template <typename Visit>
  void visit_near(std::uint32_t i, int reach, Visit&& visit) const;

  // Connected components of the given voxels, each ascending, the one with the lowest index first. Voxels are connected if they
  // are at most `reach` apart along each axis.
  std::vector<std::vector<std::uint32_t>> components(std::span<const std::uint32_t> members, int reach) const;

  // Labels that differ from the map's are written; their weights stay. Returns how many.
  std::size_t write_labels(VoxelMap& map) const;

 private:
  // Of one block: the rank of each of its voxels among the block's surface voxels, kNone for the others.
  using Ranks = std::array<std::uint16_t, kBlockVoxels>;
  static constexpr std::uint16_t kNone = 65535;

  std::vector<SurfaceVoxel> voxels_;
  std::vector<std::uint32_t> first_of_slot_;      // by slot, and one past the end
  std::vector<std::unique_ptr<Ranks>> ranks_;     // by slot; none where a block has no surface
  std::vector<std::array<Slot, 27>> neighbours_;  // by slot: x fastest, the block itself in the middle
};

template <typename Visit>
void SurfaceVoxels::visit_near(std::uint32_t i, int reach, Visit&& visit) const {
  const SurfaceVoxel& centre = voxels_[i];
  const std::array<Slot, 27>& blocks = neighbours_[centre.slot];
  const int cx = centre.voxel % kBlockSide;
  const int cy = centre.voxel / kBlockSide % kBlockSide;
  const int cz = centre.voxel / (kBlockSide * kBlockSide);
  for (int z = cz - reach; z <= cz + reach; ++z) {
    const int bz = (z + kBlockSide) / kBlockSide;
    for (int y = cy - reach; y <= cy + reach; ++y) {
      const int by = (y + kBlockSide) / kBlockSide;
      for (int x = cx - reach; x <= cx + reach; ++x) {
        const int bx = (x + kBlockSide) / kBlockSide;
        const Slot slot = blocks[static_cast<std::size_t>(bx + 3 * (by + 3 * bz))];
        if (slot == VoxelMap::kNoSlot || !ranks_[slot]) continue;
        const std::uint16_t rank = (*ranks_[slot])[static_cast<std::size_t>(
            voxel_offset(x + kBlockSide - bx * kBlockSide, y + kBlockSide - by * kBlockSide, z + kBlockSide - bz * kBlockSide))];
        if (rank != kNone) visit(first_of_slot_[slot] + rank);
      }
    }
  }
}

}  // namespace panoptic
