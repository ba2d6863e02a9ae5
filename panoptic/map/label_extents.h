// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The extent of each label in the map, without a mesh: a box around its voxels in the surface band (voxel_grid.h).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/objects.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

struct LabelExtent {
  std::uint64_t voxels = 0;
  VoxelIndex min{};
  VoxelIndex max{};
  std::array<std::int64_t, 3> sum{};

  void add(const LabelExtent& other);
  bool operator==(const LabelExtent&) const = default;
};

using LabelExtents = std::map<LabelSlot, LabelExtent>;

ExtentBox box_of(const LabelExtent& extent, double voxel_size_m);

LabelExtents label_extents(const VoxelBlock& block, BlockIndex index, float voxel_size_m);
LabelExtents label_extents(const VoxelMap& map);

}  // namespace panoptic
