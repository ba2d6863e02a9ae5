// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/voxel_map.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numeric>

#include "panoptic/base/config.h"
#include "panoptic/error.h"
#include "panoptic/labels.h"
#include "panoptic/map/block_key.h"
#include "panoptic/map/block_pager.h"
#include "panoptic/map/brick_pool.h"
#include "panoptic/map/option_fields.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr std::size_t kInitialTable = 1024;

// Mixes 8 bytes at a time; four lanes so that hashing keeps up with memory.
std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t seed) {
  PANOPTIC_ASSERT(size % 32 == 0);
  std::uint64_t lanes[4] = {seed, seed + 1, seed + 2, seed + 3};
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; i += 32) {
    for (std::size_t lane = 0; lane < 4; ++lane) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes + i + 8 * lane, 8);
      lanes[lane] = (lanes[lane] ^ word) * 0x9E3779B97F4A7C15ULL;
      lanes[lane] ^= lanes[lane] >> 29;
    }
  }
  return mixed(lanes[0] + mixed(lanes[1] + mixed(lanes[2] + mixed(lanes[3]))));
}

constexpr std::size_t kMegabyte = 1000000;

std::unique_ptr<BlockPager> pager_for(const MapOptions& options) {
  if (options.memory_limit_mb == 0) return nullptr;
  return std::make_unique<BlockPager>(
      static_cast<std::size_t>(options.memory_limit_mb) * kMegabyte,
      options.swap_folder.empty() ? std::filesystem::temp_directory_path() : std::filesystem::path(options.swap_folder),
      BlockPager::Bounds::kProcess);
}

}  // namespace

Fields grid_fields(MapOptions& o) {
  return {{"voxel_size_m", &o.voxel_size_m, "edge of a voxel in metres", in_range(0.001, 1)},
          {"truncation_voxels", &o.truncation_voxels, "half width of the updated band around the surface, in voxels",
           in_range(1, 32)},
          {"max_weight", &o.max_weight, "weight from which on old frames fade, of distance and votes; 0: they never do",
           in_range(0, 1e9)}};
}

Fields fields(MapOptions& o) {
  Fields all = grid_fields(o);
  all.push_back({"free_space",
                 &o.free_space,
                 "keep what was seen to be empty, in cells of 4 voxels; with voxels below 1.5 cm nothing is kept",
                 {}});
  all.push_back({"memory_limit_mb", &o.memory_limit_mb,
                 "megabytes of memory for all but networks; voxels beyond lie in a file until they are needed; 0: no limit",
                 in_range(0, 1e6)});
  all.push_back({"swap_folder", &o.swap_folder, "where that file lies; empty: the output folder", {}});
  all.push_back(
      {"log", &o.log,
       "reference: keep poses and labels of all frames, so that the map can follow corrected poses; copy: depth and colour, too, "
       "which are else read again from the recording; none; auto: reference for run --map",
       one_of({"auto", "reference", "copy", "none"})});
  all.push_back({"log_limit_mb", &o.log_limit_mb,
                 "megabytes of memory that these may take; a map with more cannot follow any longer", in_range(1, 1e6)});
  all.push_back({"pose_tolerance_m", &o.pose_tolerance_m,
                 "a corrected pose counts if it moves a point 2 m before the camera by more than this", in_range(0, 1)});
  return all;
}

VoxelMap::VoxelMap(const MapOptions& options)
    : voxel_size_m_(options.voxel_size_m),
      truncation_m_(options.truncation_voxels * options.voxel_size_m),
      max_weight_(options.max_weight > 0 ? options.max_weight : std::numeric_limits<float>::infinity()),
      pager_(pager_for(options)),
      pool_(pager_ ? nullptr : std::make_unique<BrickPool>()),
      table_keys_(kInitialTable, 0),
      table_slots_(kInitialTable, kNoSlot) {}

VoxelMap::VoxelMap(VoxelMap&&) noexcept = default;
VoxelMap& VoxelMap::operator=(VoxelMap&&) noexcept = default;
VoxelMap::~VoxelMap() = default;

void VoxelMap::touch(Slot slot) const { pager_->touch(slot); }

std::uint64_t VoxelMap::begin_epoch() {
  if (pager_) pager_->tick();
  return ++epoch_;
}

std::size_t VoxelMap::memory_bytes() const {
  const std::size_t per_block = sizeof(VoxelBlock) + sizeof(blocks_[0]) + sizeof(indices_[0]) + sizeof(changed_at_[0]);
  return (pager_ ? pager_->bytes_in_memory() : pool_->bytes()) + blocks_.size() * per_block +
         table_keys_.size() * (sizeof(table_keys_[0]) + sizeof(table_slots_[0]));
}

std::size_t VoxelMap::observed_voxels() const {
  std::size_t observed = 0;
  for (Slot slot = 0; slot < blocks_.size(); ++slot) {
    const VoxelBlock& b = block(slot);
    for (int n = 0; n < kBlockBricks; ++n) {
      const float* weight = b.brick(n).plane(FloatPlane::kWeight);
      observed += static_cast<std::size_t>(std::count_if(weight, weight + b.brick(n).count(), [](float w) { return w > 0; }));
    }
  }
  return observed;
}

// The place of the key, or the free place where it would go.
std::size_t VoxelMap::probe(std::uint64_t key) const {
  const std::size_t mask = table_keys_.size() - 1;
  std::size_t place = mixed(key) & mask;
  while (table_keys_[place] != 0 && table_keys_[place] != key + 1) place = (place + 1) & mask;
  return place;
}

Slot VoxelMap::find_slot(BlockIndex index) const {
  if (!in_range(index)) return kNoSlot;
  return table_slots_[probe(pack(index))];
}

const VoxelBlock* VoxelMap::find(BlockIndex index) const {
  const Slot slot = find_slot(index);
  return slot == kNoSlot ? nullptr : &block(slot);
}

Slot VoxelMap::allocate(BlockIndex index) {
  PANOPTIC_ASSERT(in_range(index));
  std::size_t place = probe(pack(index));
  if (table_keys_[place] != 0) return table_slots_[place];
  if (2 * (blocks_.size() + 1) > table_keys_.size()) {
    grow_table();
    place = probe(pack(index));
  }
  const auto slot = static_cast<Slot>(blocks_.size());
  blocks_.push_back(std::make_unique<VoxelBlock>(pager_ ? pager_->add() : *pool_));
  indices_.push_back(index);
  changed_at_.push_back(epoch_);
  table_keys_[place] = pack(index) + 1;
  table_slots_[place] = slot;
  return slot;
}

void VoxelMap::grow_table() {
  const std::size_t size = 2 * table_keys_.size();
  table_keys_.assign(size, 0);
  table_slots_.assign(size, kNoSlot);
  for (Slot slot = 0; slot < blocks_.size(); ++slot) {
    const std::uint64_t key = pack(indices_[slot]);
    const std::size_t place = probe(key);
    table_keys_[place] = key + 1;
    table_slots_[place] = slot;
  }
}

std::vector<Slot> VoxelMap::changed_since(std::uint64_t epoch) const {
  std::vector<Slot> slots;
  for (Slot slot = 0; slot < blocks_.size(); ++slot) {
    if (changed_at_[slot] > epoch) slots.push_back(slot);
  }
  return slots;
}

std::vector<bool> ids_in_use(const VoxelMap& map) {
  std::vector<bool> used(kLabelSlots, false);
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    used[number(LabelSlot::kUnknown)] = true;  // some voxel is always without a label
    const VoxelBlock& block = map.block(slot);
    for (int n = 0; n < kBlockBricks; ++n) {
      const Brick& brick = block.brick(n);
      const std::uint16_t* labels = brick.plane(WordPlane::kLabel);
      for (int i = 0; i < brick.count(); ++i) used[labels[i]] = true;
    }
  }
  return used;
}

// It is one of all voxels, stored or not, so that it does not depend on how they are stored.
std::uint64_t VoxelMap::hash() const {
  constexpr std::size_t kHashedTogether = 16;
  std::vector<Slot> order(blocks_.size());
  std::iota(order.begin(), order.end(), Slot{0});
  std::sort(order.begin(), order.end(), [&](Slot a, Slot b) { return pack(indices_[a]) < pack(indices_[b]); });
  std::vector<std::uint64_t> hashes(order.size());
  parallel_for((order.size() + kHashedTogether - 1) / kHashedTogether, [&](std::size_t task) {
    const auto planes = std::make_unique_for_overwrite<BlockPlanes>();
    for (std::size_t i = task * kHashedTogether; i < std::min(order.size(), (task + 1) * kHashedTogether); ++i) {
      block(order[i]).unpack(*planes);
      hashes[i] = hash_bytes(planes.get(), sizeof(BlockPlanes), pack(indices_[order[i]]));
    }
  });
  return std::accumulate(hashes.begin(), hashes.end(), std::uint64_t{blocks_.size()},
                         [](std::uint64_t sum, std::uint64_t h) { return mixed(sum * 31 + h); });
}

}  // namespace panoptic
