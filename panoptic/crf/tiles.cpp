// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/tiles.h"

#include <algorithm>
#include <array>
#include <unordered_map>

#include "panoptic/map/block_key.h"

namespace panoptic {
namespace {

std::array<BlockIndex, 6> neighbours(BlockIndex i) {
  return {{{i.x - 1, i.y, i.z},
           {i.x + 1, i.y, i.z},
           {i.x, i.y - 1, i.z},
           {i.x, i.y + 1, i.z},
           {i.x, i.y, i.z - 1},
           {i.x, i.y, i.z + 1}}};
}

struct MixedHash {
  std::size_t operator()(std::uint64_t key) const { return mixed(key); }
};

// Blocks by key that are in no tile yet.
using Free = std::unordered_map<std::uint64_t, Slot, MixedHash>;

// Breadth first, so that regions come out round: little border for their volume.
std::vector<Slot> grow_region(const VoxelMap& map, std::uint64_t seed, std::size_t most_blocks, Free& free) {
  std::vector<Slot> region = {free.at(seed)};
  free.erase(seed);
  for (std::size_t next = 0; next < region.size(); ++next) {
    for (const BlockIndex n : neighbours(map.index_of(region[next]))) {
      if (region.size() == most_blocks) return region;
      const auto found = free.find(pack(n));
      if (found == free.end()) continue;
      region.push_back(found->second);
      free.erase(found);
    }
  }
  return region;
}

}  // namespace

std::vector<std::vector<Slot>> divide_into_tiles(const VoxelMap& map, std::span<const Slot> slots, std::size_t most_blocks) {
  const auto key_of = [&](Slot slot) { return pack(map.index_of(slot)); };
  std::vector<Slot> order(slots.begin(), slots.end());
  std::sort(order.begin(), order.end(), [&](Slot a, Slot b) { return key_of(a) < key_of(b); });
  if (order.empty()) return {};
  if (most_blocks == 0) return {order};
  Free free;
  for (const Slot slot : order) free.emplace(key_of(slot), slot);
  std::vector<std::vector<Slot>> tiles;
  for (const Slot seed : order) {
    if (!free.contains(key_of(seed))) continue;
    tiles.push_back(grow_region(map, key_of(seed), most_blocks, free));
    std::sort(tiles.back().begin(), tiles.back().end(), [&](Slot a, Slot b) { return key_of(a) < key_of(b); });
  }
  return tiles;
}

}  // namespace panoptic
