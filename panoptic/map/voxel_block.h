// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// 16^3 voxels, one plane per property, so that a pass reads only what it needs and its loops vectorise.
//
//   offset   plane          type       meaning
//        0   distance       f32[4096]  truncated signed distance, metres, positive in front of the surface
//    16384   weight         f32[4096]  W^D, 0 = never observed
//    32768   label_weight   f32[4096]  W^L
//    49152   vote_sum       f32[4096]  W^V, the weight of all votes, whatever they were for; 0 = nobody ever voted
//    65536   label          u16[4096]  LabelSlot, 0 = unknown
//    73728   red            u16[4096]  8.8 fixed point: the mean keeps moving after hundreds of frames
//    81920   green          u16[4096]
//    90112   blue           u16[4096]
//    98304   end: 96 KiB, 24 bytes a voxel
//
// Voxel (x, y, z) of a block is at index x + 16 y + 256 z; its centre lies at (16 * block + (x, y, z) + 0.5) * voxel size.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace panoptic {

inline constexpr int kBlockSide = 16;
inline constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

struct alignas(64) VoxelBlock {
  std::array<float, kBlockVoxels> distance{};
  std::array<float, kBlockVoxels> weight{};
  std::array<float, kBlockVoxels> label_weight{};
  std::array<float, kBlockVoxels> vote_sum{};
  std::array<std::uint16_t, kBlockVoxels> label{};
  std::array<std::uint16_t, kBlockVoxels> red{};
  std::array<std::uint16_t, kBlockVoxels> green{};
  std::array<std::uint16_t, kBlockVoxels> blue{};
};

static_assert(sizeof(VoxelBlock) == 98304);

// How much of what was voted is for the label: W^L / W^V of Eq. 18, from 0 to 1; 0 where nobody voted.
constexpr float label_share(float label_weight, float vote_sum) {
  if (!(vote_sum > 0)) return 0;
  return label_weight < vote_sum ? label_weight / vote_sum : 1.0F;
}

constexpr int voxel_offset(int x, int y, int z) { return x + kBlockSide * (y + kBlockSide * z); }

}  // namespace panoptic
