// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/open_floor.h"

#include <bit>
#include <cmath>

#include "panoptic/map/voxel_grid.h"
#include "panoptic/planning/walls.h"

namespace panoptic {
namespace {

constexpr double kAnkle_m = 0.05;
constexpr double kEyes_m = 1.8;
constexpr int kEnoughPoints = 3;  // one alone may be noise

Eigen::AlignedBox2d area_of(const LabelledSurface& surface) {
  Eigen::AlignedBox2d area;
  for (const LabelledPoint& p : surface.wall) area.extend(p.at.head<2>());
  for (const LabelledPoint& p : surface.floor) area.extend(p.at.head<2>());
  for (const auto& [id, points] : surface.of_object) {
    for (const LabelledPoint& p : points) area.extend(p.at.head<2>());
  }
  return area;
}

// Calls visit for the middles of observed voxels in front of surfaces.
template <typename Visit>
void visit_empty_voxels(const VoxelMap& map, const Visit& visit) {
  const float far_m = map.voxel_size_m() / 2;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const VoxelBlock& block = map.block(slot);
    const VoxelIndex first = first_voxel(map.index_of(slot));
    for (int number = 0; number < kBlockBricks; ++number) {
      const Brick& brick = block.brick(number);
      const float* distance = brick.plane(FloatPlane::kDistance);
      const float* weight = brick.plane(FloatPlane::kWeight);
      int i = 0;
      for (std::uint64_t rest = brick.stored(); rest != 0; rest &= rest - 1, ++i) {
        if (!(weight[i] > 0 && distance[i] > far_m)) continue;
        visit(center_m(voxel_at(first, offset_in_block(number, std::countr_zero(rest))), map.voxel_size_m()));
      }
    }
  }
}

// Calls visit for points in free cells as far apart as voxels.
template <typename Visit>
void visit_free_cells(const FreeSpaceMap& space, const Visit& visit) {
  const double voxel_m = double{space.cell_size_m()} / kCellVoxels;
  space.for_each([&](const CellIndex& cell, Space what) {
    if (what != Space::kFree) return;
    for (int n = 0; n < kCellVoxels * kCellVoxels * kCellVoxels; ++n) {
      const Vec3d inside(n % kCellVoxels + 0.5, n / kCellVoxels % kCellVoxels + 0.5, n / (kCellVoxels * kCellVoxels) + 0.5);
      visit(Vec3d((Vec3d(cell[0], cell[1], cell[2]) * kCellVoxels + inside) * voxel_m));
    }
  });
}

void mark(const FlatGrid& grid, const std::vector<LabelledPoint>& points, const Stretch& height, std::vector<int>& count) {
  for (const LabelledPoint& p : points) {
    if (p.at.z() < height.low_m || p.at.z() > height.high_m) continue;
    if (const auto cell = grid.cell_at(p.at.head<2>())) ++count[*cell];
  }
}

}  // namespace

bool OpenFloor::is_open(const Vec2d& p) const {
  const auto cell = grid.cell_at(p);
  return cell && open[*cell] != 0;
}

bool OpenFloor::has_wall_near(const Vec2d& p, double distance_m) const {
  const int reach = static_cast<int>(std::ceil(distance_m / grid.cell_m));
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const auto cell = grid.cell_at(p + Vec2d(dx, dy) * grid.cell_m);
      if (cell && wall[*cell] != 0 && (grid.middle(*cell) - p).norm() <= distance_m) return true;
    }
  }
  return false;
}

bool seen_empty(const PanopticMap& map, const Vec3d& in_world) {
  const auto place = place_of(in_world, map.voxels.voxel_size_m());
  const VoxelBlock* block = place ? map.voxels.find(place->block) : nullptr;
  if (block != nullptr && block->weight(place->offset) > 0) return block->distance(place->offset) > map.voxels.voxel_size_m() / 2;
  const auto cell = map.free_space.cell_around(in_world);
  return cell && map.free_space.at(*cell) == Space::kFree;
}

OpenFloor open_floor(const PanopticMap& map, const LabelledSurface& surface, const Pose& grid_from_world) {
  constexpr int kMargin = 8;
  OpenFloor floor;
  floor.grid = grid_over(area_of(surface), 2 * surface.voxel_m, kMargin);
  std::vector<int> walls(floor.grid.size(), 0);
  std::vector<int> empty(floor.grid.size(), 0);
  mark(floor.grid, surface.wall, {kWallLow_m, kWallHigh_m}, walls);
  mark(floor.grid, surface.floor, {-0.1, 0.1}, empty);
  const auto add = [&](const Vec3d& in_world) {
    const Vec3d p = grid_from_world * in_world;
    if (p.z() < kAnkle_m || p.z() > kEyes_m) return;
    if (const auto cell = floor.grid.cell_at(p.head<2>())) ++empty[*cell];
  };
  visit_empty_voxels(map.voxels, add);
  visit_free_cells(map.free_space, add);
  floor.wall.assign(floor.grid.size(), 0);
  floor.open.assign(floor.grid.size(), 0);
  for (std::size_t cell = 0; cell < floor.grid.size(); ++cell) {
    floor.wall[cell] = walls[cell] >= kEnoughPoints ? 1 : 0;
    floor.open[cell] = walls[cell] < kEnoughPoints && empty[cell] >= kEnoughPoints ? 1 : 0;
  }
  return floor;
}

}  // namespace panoptic
