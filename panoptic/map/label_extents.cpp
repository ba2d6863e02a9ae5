// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/label_extents.h"

#include <algorithm>

#include "panoptic/parallel.h"

namespace panoptic {

void LabelExtent::add(const LabelExtent& other) {
  for (std::size_t a = 0; a < 3; ++a) {
    min[a] = voxels == 0 ? other.min[a] : std::min(min[a], other.min[a]);
    max[a] = voxels == 0 ? other.max[a] : std::max(max[a], other.max[a]);
    sum[a] += other.sum[a];
  }
  voxels += other.voxels;
}

ExtentBox box_of(const LabelExtent& extent, double voxel_size_m) {
  ExtentBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    box.min_m[axis] = extent.min[a] * voxel_size_m;
    box.max_m[axis] = (extent.max[a] + 1.0) * voxel_size_m;
    const double mean = static_cast<double>(extent.sum[a]) / static_cast<double>(std::max<std::uint64_t>(extent.voxels, 1));
    box.center_m[axis] = (mean + 0.5) * voxel_size_m;
  }
  return box;
}

LabelExtents label_extents(const VoxelBlock& block, BlockIndex index, float voxel_size_m) {
  LabelExtents extents;
  LabelExtent* last = nullptr;  // labels come in long runs
  LabelSlot last_label = LabelSlot::kUnknown;
  visit_surface(block, index, voxel_size_m, [&](LabelSlot label, const VoxelIndex& voxel) {
    if (last == nullptr || label != last_label) {
      last_label = label;
      last = &extents[label];
    }
    LabelExtent one{.voxels = 1};
    one.min = voxel;
    one.max = voxel;
    for (std::size_t a = 0; a < 3; ++a) one.sum[a] = voxel[a];
    last->add(one);
  });
  return extents;
}

LabelExtents label_extents(const VoxelMap& map) {
  std::vector<LabelExtents> by_slot(map.block_count());
  parallel_for(by_slot.size(), [&](std::size_t i) {
    const auto slot = static_cast<Slot>(i);
    by_slot[i] = label_extents(map.block(slot), map.index_of(slot), map.voxel_size_m());
  });
  LabelExtents all;
  for (const LabelExtents& extents : by_slot) {
    for (const auto& [label, extent] : extents) all[label].add(extent);
  }
  return all;
}

}  // namespace panoptic
