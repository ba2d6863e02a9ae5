// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/surface_voxels.h"

#include <algorithm>
#include <cmath>

#include "panoptic/base/parallel.h"

namespace panoptic {
namespace {

constexpr float kBand_voxels = 1.5F;
constexpr std::size_t kIds = 65536;

std::vector<SurfaceVoxel> voxels_of(const VoxelMap& map, Slot slot) {
  std::vector<SurfaceVoxel> voxels;
  const VoxelBlock& block = map.block(slot);
  const BlockIndex index = map.index_of(slot);
  const float band_m = kBand_voxels * map.voxel_size_m();
  for (int v = 0; v < kBlockVoxels; ++v) {
    const auto i = static_cast<std::size_t>(v);
    if (block.weight[i] <= 0 || std::abs(block.distance[i]) > band_m) continue;
    voxels.push_back({{index.x * kBlockSide + v % kBlockSide, index.y * kBlockSide + v / kBlockSide % kBlockSide,
                       index.z * kBlockSide + v / (kBlockSide * kBlockSide)},
                      static_cast<PanopticId>(block.label[i]),
                      slot,
                      static_cast<std::uint16_t>(v)});
  }
  return voxels;
}

std::array<Slot, 27> neighbours_of(const VoxelMap& map, BlockIndex c) {
  std::array<Slot, 27> slots{};
  for (int n = 0; n < 27; ++n) {
    slots[static_cast<std::size_t>(n)] = map.find_slot({c.x + n % 3 - 1, c.y + n / 3 % 3 - 1, c.z + n / 9 - 1});
  }
  return slots;
}

}  // namespace

SurfaceVoxels::SurfaceVoxels(const VoxelMap& map) : ranks_(map.block_count()), neighbours_(map.block_count()) {
  std::vector<std::vector<SurfaceVoxel>> by_slot(map.block_count());
  parallel_for(by_slot.size(), [&](std::size_t slot) {
    by_slot[slot] = voxels_of(map, static_cast<Slot>(slot));
    neighbours_[slot] = neighbours_of(map, map.index_of(static_cast<Slot>(slot)));
    if (by_slot[slot].empty()) return;
    ranks_[slot] = std::make_unique<Ranks>();
    ranks_[slot]->fill(kNone);
    for (std::size_t r = 0; r < by_slot[slot].size(); ++r)
      (*ranks_[slot])[by_slot[slot][r].voxel] = static_cast<std::uint16_t>(r);
  });
  first_of_slot_.reserve(by_slot.size() + 1);
  for (const std::vector<SurfaceVoxel>& voxels : by_slot) {
    first_of_slot_.push_back(static_cast<std::uint32_t>(voxels_.size()));
    voxels_.insert(voxels_.end(), voxels.begin(), voxels.end());
  }
  first_of_slot_.push_back(static_cast<std::uint32_t>(voxels_.size()));
}

VoxelsByLabel SurfaceVoxels::by_label() const {
  VoxelsByLabel result;
  std::vector<std::vector<std::uint32_t>> voxels(kIds);
  for (std::uint32_t i = 0; i < voxels_.size(); ++i) voxels[number(voxels_[i].label)].push_back(i);
  for (std::size_t id = 0; id < kIds; ++id) {
    if (!voxels[id].empty()) result.emplace(static_cast<PanopticId>(id), std::move(voxels[id]));
  }
  return result;
}

std::vector<std::vector<std::uint32_t>> SurfaceVoxels::components(std::span<const std::uint32_t> members, int reach) const {
  std::vector<bool> waiting(voxels_.size(), false);
  for (const std::uint32_t member : members) waiting[member] = true;
  std::vector<std::uint32_t> seeds(members.begin(), members.end());
  std::sort(seeds.begin(), seeds.end());
  std::vector<std::vector<std::uint32_t>> result;
  for (const std::uint32_t seed : seeds) {
    if (!waiting[seed]) continue;
    waiting[seed] = false;
    std::vector<std::uint32_t> component = {seed};
    for (std::size_t next = 0; next < component.size(); ++next) {
      visit_near(component[next], reach, [&](std::uint32_t neighbour) {
        if (!waiting[neighbour]) return;
        waiting[neighbour] = false;
        component.push_back(neighbour);
      });
    }
    std::sort(component.begin(), component.end());
    result.push_back(std::move(component));
  }
  return result;
}

std::size_t SurfaceVoxels::write_labels(VoxelMap& map) const {
  std::size_t written = 0;
  for (const SurfaceVoxel& v : voxels_) {
    std::uint16_t& label = map.block(v.slot).label[v.voxel];
    if (label == number(v.label)) continue;
    label = number(v.label);
    map.mark_changed(v.slot);
    ++written;
  }
  return written;
}

}  // namespace panoptic
