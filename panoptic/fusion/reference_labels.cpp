// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/reference_labels.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "panoptic/base/clones.h"
#include "panoptic/base/floor.h"
#include "panoptic/map/cached_lookup.h"
#include "panoptic/parallel.h"

namespace panoptic {

namespace kernels {

// A piece of a row of pixels on its way through the loops.
constexpr int kPiece = 128;
struct VoxelPiece {
  alignas(64) std::array<std::int32_t, kPiece> x;
  alignas(64) std::array<std::int32_t, kPiece> y;
  alignas(64) std::array<std::int32_t, kPiece> z;
  alignas(64) std::array<std::int32_t, kPiece> voxel;    // brick * 64 + voxel in the brick; -1 = no depth
  alignas(64) std::array<std::int32_t, kPiece> changed;  // not 0 where the block is another one than the pixel's before
};

// Pixel u of a row at depth z lies in the voxel floor((per_x * x[u] + base) * z + origin).
struct RowToVoxels {
  float per_x[3], base[3], origin[3];
};

void find_voxels(const RowToVoxels& to_voxels, const float* x, const float* depth, int count, VoxelPiece& piece);
void look_up_piece(const VoxelPiece& piece, int count, CachedLookup& lookup, LabelSlot* labels);

PANOPTIC_CLONES
void find_voxels(const RowToVoxels& to_voxels, const float* x, const float* depth, int count, VoxelPiece& piece) {
  const RowToVoxels r = to_voxels;
  const float* __restrict xs = x;
  const float* __restrict zs = depth;
  VoxelPiece* __restrict p = &piece;
  for (int k = 0; k < count; ++k) {
    p->x[k] = floor_to_int((r.per_x[0] * xs[k] + r.base[0]) * zs[k] + r.origin[0]);
    p->y[k] = floor_to_int((r.per_x[1] * xs[k] + r.base[1]) * zs[k] + r.origin[1]);
    p->z[k] = floor_to_int((r.per_x[2] * xs[k] + r.base[2]) * zs[k] + r.origin[2]);
  }
  for (int k = 0; k < count; ++k) {
    const std::int32_t voxel = (p->x[k] & 3) | (p->y[k] & 3) << 2 | (p->z[k] & 3) << 4;
    const std::int32_t brick = (p->x[k] >> 2 & 3) | (p->y[k] >> 2 & 3) << 2 | (p->z[k] >> 2 & 3) << 4;
    p->voxel[k] = zs[k] > 0 ? brick * kBrickVoxels + voxel : -1;
    p->x[k] >>= 4;
    p->y[k] >>= 4;
    p->z[k] >>= 4;
  }
  p->changed[0] = 1;
  for (int k = 1; k < count; ++k) {
    p->changed[k] = (p->x[k] ^ p->x[k - 1]) | (p->y[k] ^ p->y[k - 1]) | (p->z[k] ^ p->z[k - 1]);
  }
}

// A clone for the sake of counting bits, which finds a voxel among those that its brick stores.
PANOPTIC_CLONES
void look_up_piece(const VoxelPiece& piece, int count, CachedLookup& lookup, LabelSlot* labels) {
  const VoxelBlock* block = nullptr;
  for (int k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (piece.changed[i] != 0) block = lookup.find({piece.x[i], piece.y[i], piece.z[i]});
    const std::int32_t voxel = piece.voxel[i];
    const bool known = (voxel >= 0) & (block != nullptr);
    labels[k] =
        known ? static_cast<LabelSlot>(block->brick(voxel / kBrickVoxels).label(voxel % kBrickVoxels)) : LabelSlot::kUnknown;
  }
}

}  // namespace kernels

namespace {

constexpr std::size_t kBands = 16;  // of rows

// Everything that is the same for all rows.
struct PixelGrid {
  const VoxelMap& map;
  const RegisteredFrame& registered;
  std::vector<float> x;  // of each column, at depth 1
};

void look_up_row(const PixelGrid& grid, std::size_t first, const kernels::RowToVoxels& to_voxels, CachedLookup& lookup,
                 LabelSlot* labels) {
  kernels::VoxelPiece piece;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled as far as it is read
  const int width = grid.registered.width;
  for (int begin = 0; begin < width; begin += kernels::kPiece) {
    const int count = std::min(kernels::kPiece, width - begin);
    const auto at = first + static_cast<std::size_t>(begin);
    kernels::find_voxels(to_voxels, grid.x.data() + begin, grid.registered.depth.data() + at, count, piece);
    kernels::look_up_piece(piece, count, lookup, labels + begin);
  }
}

}  // namespace

void reference_labels(const VoxelMap& map, const Frame& frame, const RegisteredFrame& registered,
                      std::vector<LabelSlot>& labels) {
  labels.resize(registered.pixel_count());
  const Camera& camera = frame.depth_camera;
  const double per_metre = 1.0 / map.voxel_size_m();
  const Eigen::Matrix3f r = (frame.world_from_camera.linear() * per_metre).cast<float>();
  const Vec3f t = (frame.world_from_camera.translation() * per_metre).cast<float>();
  PixelGrid grid{map, registered, std::vector<float>(static_cast<std::size_t>(registered.width))};
  for (int u = 0; u < registered.width; ++u) {
    grid.x[static_cast<std::size_t>(u)] = static_cast<float>((u - camera.cx) / camera.fx);
  }
  const auto height = static_cast<std::size_t>(registered.height);
  parallel_for(kBands, [&](std::size_t band) {
    CachedLookup lookup(map);
    for (std::size_t row = height * band / kBands; row < height * (band + 1) / kBands; ++row) {
      const auto y = static_cast<float>((static_cast<double>(row) - camera.cy) / camera.fy);
      const Vec3f base = r.col(1) * y + r.col(2);
      kernels::RowToVoxels to_voxels{};
      for (int a = 0; a < 3; ++a) {
        to_voxels.per_x[a] = r(a, 0);
        to_voxels.base[a] = base[a];
        to_voxels.origin[a] = t[a];
      }
      const std::size_t first = row * static_cast<std::size_t>(registered.width);
      look_up_row(grid, first, to_voxels, lookup, labels.data() + first);
    }
  });
}

}  // namespace panoptic
