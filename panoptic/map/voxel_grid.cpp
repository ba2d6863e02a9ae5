// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/voxel_grid.h"

namespace panoptic {

BlockBits surface_bits(const VoxelBlock& block, float band_m) {
  BlockBits rows{};
  for (int n = 0; n < kBlockBricks; ++n) {
    const Brick& brick = block.brick(n);
    const float* distance = brick.plane(FloatPlane::kDistance);
    const float* weight = brick.plane(FloatPlane::kWeight);
    std::array<std::uint8_t, kBrickVoxels> is_in{};  // a loop that compilers vectorise
    for (int i = 0; i < brick.capacity(); ++i) {
      is_in[static_cast<std::size_t>(i)] =
          static_cast<std::uint8_t>((weight[i] > 0 ? 1 : 0) & (std::abs(distance[i]) <= band_m ? 1 : 0));
    }
    std::size_t place = 0;
    for (std::uint64_t rest = brick.stored(); rest != 0; rest &= rest - 1) {
      const int offset = offset_in_block(n, std::countr_zero(rest));
      std::uint16_t& row = rows[static_cast<std::size_t>(offset / kBlockSide)];
      row = static_cast<std::uint16_t>(row | unsigned{is_in[place++]} << (offset % kBlockSide));
    }
  }
  return rows;
}

}  // namespace panoptic
