// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/cell_grid.h"

#include <unordered_map>

#include "panoptic/error.h"
#include "panoptic/map/block_key.h"
#include "panoptic/map/voxel_grid.h"

namespace panoptic {
namespace {

std::int32_t floor_division(std::int32_t a, std::int32_t b) { return a / b - (a % b < 0 ? 1 : 0); }

struct MixedHash {
  std::size_t operator()(std::uint64_t key) const { return mixed(key); }
};

}  // namespace

CellGrid::CellGrid(const SurfaceVoxels& surface, int voxels_per_cell) {
  PANOPTIC_ASSERT(voxels_per_cell > 0);
  std::unordered_map<std::uint64_t, Slot, MixedHash> slots;
  std::vector<BlockIndex> blocks;
  const auto slot_of = [&](BlockIndex block) {
    const auto [found, is_new] = slots.try_emplace(pack(block), static_cast<Slot>(blocks.size()));
    if (is_new) blocks.push_back(block);
    return found->second;
  };
  places_.reserve(surface.size());
  BlockIndex last;
  Slot slot = VoxelMap::kNoSlot;
  for (std::uint32_t i = 0; i < surface.size(); ++i) {
    const auto [x, y, z] = surface[i].at;
    const auto [block, offset] = panoptic::place_of(
        VoxelIndex{floor_division(x, voxels_per_cell), floor_division(y, voxels_per_cell), floor_division(z, voxels_per_cell)});
    if (slot == VoxelMap::kNoSlot || block != last) slot = slot_of(block);  // neighbours nearly always share it
    last = block;
    places_.emplace_back(slot, offset);
  }
  neighbours_.resize(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (int n = 0; n < kNeighbours; ++n) {
      const auto found = slots.find(pack(neighbour(blocks[b], n)));
      neighbours_[b][static_cast<std::size_t>(n)] = found == slots.end() ? VoxelMap::kNoSlot : found->second;
    }
  }
}

}  // namespace panoptic
