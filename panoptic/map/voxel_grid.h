// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The grid of voxels: which voxel a point lies in, where a voxel of a block lies, which blocks are neighbours, and which voxels
// are near the surface. Voxels are counted through the whole map; the centre of voxel v lies at (v + 0.5) * voxel size.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

using VoxelIndex = std::array<std::int32_t, 3>;

// A voxel by its block and the offset there (voxel_block.h).
struct VoxelPlace {
  BlockIndex block;
  std::uint16_t offset = 0;
};

// The block's voxel with the lowest coordinates.
constexpr VoxelIndex first_voxel(BlockIndex block) { return {block.x * kBlockSide, block.y * kBlockSide, block.z * kBlockSide}; }

// The voxel at an offset of the block that begins at `first`.
constexpr VoxelIndex voxel_at(const VoxelIndex& first, int offset) {
  return {first[0] + offset % kBlockSide, first[1] + offset / kBlockSide % kBlockSide,
          first[2] + offset / (kBlockSide * kBlockSide)};
}

constexpr VoxelPlace place_of(const VoxelIndex& v) {
  static_assert(kBlockSide == 16);
  return {{v[0] >> 4, v[1] >> 4, v[2] >> 4}, static_cast<std::uint16_t>(voxel_offset(v[0] & 15, v[1] & 15, v[2] & 15))};
}

// The voxel around a point in metres, world; nothing if the point is not finite or farther out than a map reaches.
inline std::optional<VoxelPlace> place_of(const Vec3d& point_m, double voxel_size_m) {
  const Vec3d voxel = (point_m / voxel_size_m).array().floor();
  constexpr double kFarthest = double{kMaxBlockCoordinate} * kBlockSide;
  if (!voxel.allFinite() || voxel.cwiseAbs().maxCoeff() > kFarthest) return std::nullopt;
  const Eigen::Vector3i v = voxel.cast<int>();
  return place_of(VoxelIndex{v.x(), v.y(), v.z()});
}

inline Vec3d center_m(const VoxelIndex& v, double voxel_size_m) {
  return (Vec3d(v[0], v[1], v[2]) + Vec3d::Constant(0.5)) * voxel_size_m;
}

// Blocks around a block, itself in the middle: number n is one step of step_to(n) away, and kNeighbours - 1 - n is its opposite.
inline constexpr int kNeighbours = 27;

constexpr BlockIndex step_to(int n) { return {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}; }

constexpr BlockIndex neighbour(BlockIndex block, int n) {
  const BlockIndex step = step_to(n);
  return {block.x + step.x, block.y + step.y, block.z + step.z};
}

// Half the width of the surface band, the observed voxels that count as surface.
inline constexpr float kSurfaceBand_voxels = 1.5F;

// Voxels of one block, a bit each (the lowest is x = 0), by row along x: row y + 16 z.
inline constexpr int kBlockRows = kBlockSide * kBlockSide;
using BlockBits = std::array<std::uint16_t, kBlockRows>;

// The voxels that were observed within `band_m` of the surface.
BlockBits surface_bits(const VoxelBlock& block, float band_m);

// Calls visit(label, coordinates) for every voxel of the block in the surface band, in the order of the voxels.
template <typename Visit>
void visit_surface(const VoxelBlock& block, BlockIndex index, float voxel_size_m, const Visit& visit) {
  const BlockBits surface = surface_bits(block, kSurfaceBand_voxels * voxel_size_m);
  const VoxelIndex first = first_voxel(index);
  for (int row = 0; row < kBlockRows; ++row) {
    for (unsigned bits = surface[static_cast<std::size_t>(row)]; bits != 0; bits &= bits - 1) {
      const int offset = row * kBlockSide + std::countr_zero(bits);
      visit(static_cast<LabelSlot>(block.label(offset)), voxel_at(first, offset));
    }
  }
}

}  // namespace panoptic
