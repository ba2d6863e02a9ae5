// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/relabelling.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "panoptic/base/parallel.h"

namespace panoptic {
namespace {

constexpr std::size_t kLabels = 65536;

// The most frequent label around a hole, other holes left out; unknown where there is nothing.
PanopticId label_around(std::uint32_t hole, const SurfaceVoxels& surface, const std::vector<bool>& open) {
  std::map<PanopticId, int> counts;
  surface.visit_near(hole, 1, [&](std::uint32_t neighbour) {
    if (!open[neighbour]) ++counts[surface.label(neighbour)];
  });
  const auto best =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return best == counts.end() ? PanopticId::kNoVote : best->first;
}

}  // namespace

Renaming::Renaming() : new_label_(kLabels) { std::iota(new_label_.begin(), new_label_.end(), std::uint16_t{0}); }

void Renaming::apply(VoxelMap& map, SurfaceVoxels& surface) const {
  std::vector<char> changed(map.block_count(), 0);
  parallel_for(changed.size(), [&](std::size_t slot) {
    for (std::uint16_t& label : map.block(static_cast<Slot>(slot)).label) {
      if (new_label_[label] == label) continue;
      label = new_label_[label];
      changed[slot] = 1;
    }
  });
  for (std::size_t slot = 0; slot < changed.size(); ++slot) {
    if (changed[slot] != 0) map.mark_changed(static_cast<Slot>(slot));
  }
  for (std::uint32_t i = 0; i < surface.size(); ++i) surface.relabel(i, of(surface.label(i)));
}

void fill_from_neighbours(std::vector<std::uint32_t> holes, SurfaceVoxels& surface) {
  std::sort(holes.begin(), holes.end());
  std::vector<bool> open(surface.size(), false);
  for (const std::uint32_t hole : holes) {
    open[hole] = true;
    surface.relabel(hole, PanopticId::kUnknown);
  }
  while (!holes.empty()) {
    std::vector<std::pair<std::uint32_t, PanopticId>> filled;
    std::vector<std::uint32_t> left;
    for (const std::uint32_t hole : holes) {
      const PanopticId label = label_around(hole, surface, open);
      if (label == PanopticId::kNoVote) {
        left.push_back(hole);
      } else {
        filled.emplace_back(hole, label);
      }
    }
    if (filled.empty()) return;
    for (const auto& [hole, label] : filled) {
      surface.relabel(hole, label);
      open[hole] = false;
    }
    holes = std::move(left);
  }
}

}  // namespace panoptic
