// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/surface_voxels.h"

#include <memory>
#include <numeric>

#include "panoptic/base/value_runs.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

LabelBits labels_in(const VoxelBlock& block) {
  LabelBits bits;
  add_to(bits, number(LabelSlot::kUnknown));  // of the voxels that are not stored
  for (int n = 0; n < kBlockBricks; ++n) {
    const Brick& brick = block.brick(n);
    const std::uint16_t* labels = brick.plane(WordPlane::kLabel);
    for (int i = 0; i < brick.count(); i = end_of_run(labels, i, brick.count())) add_to(bits, labels[i]);
  }
  return bits;
}

// Calls visit(x) for every bit, ascending.
template <typename Visit>
void visit_bits(unsigned bits, Visit&& visit) {
  for (; bits != 0; bits &= bits - 1) visit(std::countr_zero(bits));
}

}  // namespace

void SurfaceVoxels::meet_new_blocks(const VoxelMap& map) {
  const std::size_t known = blocks_.size();
  blocks_.resize(map.block_count());
  for (auto slot = static_cast<Slot>(known); slot < blocks_.size(); ++slot) {
    const BlockIndex c = map.index_of(slot);
    blocks_[slot].corner = first_voxel(c);
    for (int n = 0; n < kNeighbours; ++n) {
      const Slot found = map.find_slot(neighbour(c, n));
      blocks_[slot].neighbours[static_cast<std::size_t>(n)] = found;
      if (found != VoxelMap::kNoSlot) blocks_[found].neighbours[static_cast<std::size_t>(kNeighbours - 1 - n)] = slot;
    }
  }
}

void SurfaceVoxels::update(const VoxelMap& map) {
  if (map_ != &map || map.epoch() < seen_epoch_ || map.block_count() < blocks_.size()) {
    blocks_.clear();
    seen_epoch_ = 0;  // every block changed after that
  }
  map_ = &map;
  meet_new_blocks(map);
  const float band_m = kSurfaceBand_voxels * map.voxel_size_m();
  std::vector<char> is_known(blocks_.size(), 1);
  parallel_for(blocks_.size(), [&](std::size_t slot) {
    if (map.changed_at(static_cast<Slot>(slot)) <= seen_epoch_) return;
    is_known[slot] = 0;
    Block& block = blocks_[slot];
    block.surface = surface_bits(map.block(static_cast<Slot>(slot)), band_m);
    block.label_bits = labels_in(map.block(static_cast<Slot>(slot)));
    block.count = 0;
    for (std::size_t row = 0; row < block.surface.size(); ++row) {
      block.before[row] = static_cast<std::uint16_t>(block.count);
      if (block.surface[row] != 0) block.count += static_cast<std::uint32_t>(std::popcount(block.surface[row]));
    }
  });
  seen_epoch_ = map.epoch();
  collect(map, is_known);
}

// Collects the voxels; those of known blocks are the ones of the last time.
void SurfaceVoxels::collect(const VoxelMap& map, const std::vector<char>& is_known) {
  const std::vector<Entry> known = std::exchange(voxels_, {});
  const std::vector<std::uint32_t> known_first = std::exchange(first_of_slot_, {0});
  for (const Block& block : blocks_) first_of_slot_.push_back(first_of_slot_.back() + block.count);
  voxels_.resize(first_of_slot_.back());
  relabelled_.assign(blocks_.size(), 0);
  parallel_for(blocks_.size(), [&](std::size_t i) {
    const auto slot = static_cast<Slot>(i);
    Entry* next = voxels_.data() + first_of_slot_[slot];
    if (is_known[slot] != 0) {
      std::copy_n(known.data() + known_first[slot], blocks_[slot].count, next);
      return;
    }
    if (blocks_[slot].count == 0) return;
    const VoxelBlock& block = map.block(slot);
    for (std::size_t row = 0; row < kBlockRows; ++row) {
      visit_bits(blocks_[slot].surface[row], [&](int x) {
        const std::size_t voxel = row * kBlockSide + static_cast<std::size_t>(x);
        *next++ = {slot, static_cast<std::uint16_t>(voxel), static_cast<LabelSlot>(block.label(static_cast<int>(voxel)))};
      });
    }
  });
}

void SurfaceVoxels::relabel(std::uint32_t i, LabelSlot label) {
  Entry& e = voxels_[i];
  if (e.label == label) return;
  e.label = label;
  relabelled_[e.slot] = 1;
  add_to(blocks_[e.slot].label_bits, number(label));
}

VoxelsByLabel SurfaceVoxels::by_label() const {
  return by_label([](LabelSlot) { return true; });
}

VoxelsByLabel SurfaceVoxels::by_label(const std::function<bool(LabelSlot)>& wanted) const {
  std::vector<std::uint32_t> counts(kLabelSlots, 0);
  for (const Entry& e : voxels_) ++counts[number(e.label)];
  VoxelsByLabel result;
  std::vector<std::uint32_t*> next(kLabelSlots, nullptr);
  for (std::size_t id = 0; id < kLabelSlots; ++id) {
    const auto label = static_cast<LabelSlot>(id);
    if (counts[id] == 0 || !wanted(label)) continue;
    std::vector<std::uint32_t>& voxels = result[label];
    voxels.resize(counts[id]);
    next[id] = voxels.data();
  }
  for (std::uint32_t i = 0; i < voxels_.size(); ++i) {
    std::uint32_t*& place = next[number(voxels_[i].label)];
    if (place != nullptr) *place++ = i;
  }
  return result;
}

std::vector<std::vector<std::uint32_t>> SurfaceVoxels::components(std::span<const std::uint32_t> members, int reach) const {
  std::vector<std::uint32_t> seeds(members.begin(), members.end());
  if (!std::is_sorted(seeds.begin(), seeds.end())) std::sort(seeds.begin(), seeds.end());
  seeds.erase(std::unique(seeds.begin(), seeds.end()), seeds.end());
  VoxelSet waiting(*this, seeds);
  // The component by surface voxel. Entries of voxels that are not members are never read or written.
  const auto component_of = std::make_unique_for_overwrite<std::uint32_t[]>(size());
  const auto width = [reach](int, int) { return reach; };
  std::vector<std::size_t> sizes;
  std::vector<std::uint32_t> reached;
  const auto take = [&](Slot slot, int row, std::uint16_t mask) {
    const auto found = static_cast<std::uint16_t>(waiting.bits(slot, row) & mask);
    if (found == 0) return true;
    waiting.remove(slot, row, found);
    visit_bits(found, [&](int x) { reached.push_back(index_at(slot, row, x)); });
    return true;
  };
  for (const std::uint32_t seed : seeds) {
    const Entry& e = voxels_[seed];
    const auto own = static_cast<std::uint16_t>(1U << (e.voxel % kBlockSide));
    if ((waiting.bits(e.slot, e.voxel / kBlockSide) & own) == 0) continue;
    waiting.remove(e.slot, e.voxel / kBlockSide, own);
    reached.assign(1, seed);
    std::size_t next = 0;  // `reached` grows meanwhile
    while (next < reached.size()) {
      const std::uint32_t member = reached[next++];
      component_of[member] = static_cast<std::uint32_t>(sizes.size());
      visit_rows(member, reach, width, take);
    }
    sizes.push_back(reached.size());
  }
  std::vector<std::vector<std::uint32_t>> result(sizes.size());
  for (std::size_t c = 0; c < sizes.size(); ++c) result[c].reserve(sizes[c]);
  for (const std::uint32_t seed : seeds) result[component_of[seed]].push_back(seed);
  return result;
}

std::size_t SurfaceVoxels::write_labels(VoxelMap& map, FrameVotes& votes) const {
  std::size_t written = 0;
  for (Slot slot = 0; slot < blocks_.size(); ++slot) {
    if (relabelled_[slot] == 0) continue;
    for (std::uint32_t i = first_of_slot_[slot]; i < first_of_slot_[slot + 1]; ++i) {
      VoxelBlock& block = map.block(slot);
      const auto [of_slot, voxel, label] = voxels_[i];
      if (block.label(voxel) == number(label)) continue;
      votes.decide(of_slot, voxel, number(label), block);
      map.mark_changed(slot);
      ++written;
    }
  }
  return written;
}

}  // namespace panoptic
