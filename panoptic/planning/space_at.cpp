// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/space_at.h"

#include <fmt/format.h>

#include <optional>

#include "panoptic/map/voxel_grid.h"

namespace panoptic {

Space space_at(const PanopticMap& map, const Vec3d& point_m) {
  const std::optional<VoxelPlace> voxel = place_of(point_m, map.voxels.voxel_size_m());
  if (!voxel) return Space::kUnknown;
  const VoxelBlock* block = map.voxels.find(voxel->block);
  if (block != nullptr && block->weight(voxel->offset) > MesherOptions{}.min_weight) {
    return block->distance(voxel->offset) < 0 ? Space::kOccupied : Space::kFree;
  }
  const std::optional<CellIndex> cell = map.free_space.cell_around(point_m);
  return cell ? map.free_space.at(*cell) : Space::kUnknown;
}

std::string note_of_space(const PanopticMap& map) {
  if (!map.free_space.empty()) return "";
  return fmt::format(
      "the map has no free space (an older file, or map.free_space was off): what lies farther than {:.0f} cm from a surface is "
      "unknown, not free",
      100 * map.voxels.truncation_m());
}

}  // namespace panoptic
