// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/relabelling.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>

#include "panoptic/parallel.h"

namespace panoptic {
namespace {

using Counts = std::vector<std::pair<LabelSlot, int>>;

// The most frequent label around a hole, other holes left out; kNoVote where there is nothing. `counts` is for reuse.
LabelSlot label_around(std::uint32_t hole, const SurfaceVoxels& surface, const std::vector<bool>& open, Counts& counts) {
  counts.clear();
  surface.visit_near(hole, 1, [&](std::uint32_t neighbour) {
    if (open[neighbour]) return;
    const LabelSlot label = surface.label(neighbour);
    const auto known = std::find_if(counts.begin(), counts.end(), [&](const auto& c) { return c.first == label; });
    if (known == counts.end()) {
      counts.emplace_back(label, 1);
    } else {
      ++known->second;
    }
  });
  const auto best = std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
    return std::pair(a.second, -int{number(a.first)}) < std::pair(b.second, -int{number(b.first)});
  });
  return best == counts.end() ? LabelSlot::kNoVote : best->first;
}

// The holes next to these voxels, each once. `listed` has no voxel before and after.
std::vector<std::uint32_t> holes_around(std::span<const std::pair<std::uint32_t, LabelSlot>> filled, const SurfaceVoxels& surface,
                                        const std::vector<bool>& open, std::vector<bool>& listed) {
  std::vector<std::uint32_t> holes;
  for (const auto& [voxel, label] : filled) {
    surface.visit_near(voxel, 1, [&](std::uint32_t neighbour) {
      if (!open[neighbour] || listed[neighbour]) return;
      listed[neighbour] = true;
      holes.push_back(neighbour);
    });
  }
  for (const std::uint32_t hole : holes) listed[hole] = false;
  return holes;
}

}  // namespace

Renaming::Renaming() : new_label_(kLabelSlots) { std::iota(new_label_.begin(), new_label_.end(), std::uint16_t{0}); }

void Renaming::apply(VoxelMap& map, FrameVotes& votes, SurfaceVoxels& surface) const {
  votes.rename(new_label_, map);
  LabelBits before;
  LabelBits after;
  for (std::size_t label = 0; label < kLabelSlots; ++label) {
    if (new_label_[label] == label) continue;
    add_to(before, static_cast<std::uint16_t>(label));
    add_to(after, new_label_[label]);
  }
  std::vector<char> changed(map.block_count(), 0);
  parallel_for(changed.size(), [&](std::size_t i) {
    const auto slot = static_cast<Slot>(i);
    // Most blocks hold none of them; to know it saves reading their labels.
    if ((surface.label_bits(slot) & before).none()) return;
    changed[slot] = map.block(slot).rename_labels(new_label_) ? 1 : 0;
    const auto [first, end] = surface.range_of(slot);
    for (std::uint32_t v = first; v < end; ++v) surface.relabel(v, of(surface.label(v)));
    surface.add_label_bits(slot, after);
  });
  for (std::size_t slot = 0; slot < changed.size(); ++slot) {
    if (changed[slot] != 0) map.mark_changed(static_cast<Slot>(slot));
  }
}

void fill_from_neighbours(std::vector<std::uint32_t> holes, SurfaceVoxels& surface) {
  std::vector<bool> open(surface.size(), false);
  std::vector<bool> listed(surface.size(), false);
  for (const std::uint32_t hole : holes) {
    open[hole] = true;
    surface.relabel(hole, LabelSlot::kUnknown);
  }
  Counts counts;
  while (!holes.empty()) {
    std::vector<std::pair<std::uint32_t, LabelSlot>> filled;
    for (const std::uint32_t hole : holes) {
      const LabelSlot label = label_around(hole, surface, open, counts);
      if (label != LabelSlot::kNoVote) filled.emplace_back(hole, label);
    }
    for (const auto& [hole, label] : filled) {
      surface.relabel(hole, label);
      open[hole] = false;
    }
    // Only there is anything new to see.
    holes = holes_around(filled, surface, open, listed);
  }
}

}  // namespace panoptic
