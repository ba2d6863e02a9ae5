// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#include "panoptic/voxel_block.h"

namespace panoptic::kernels {

// One bit for each of 64 flags, which are 0 or 1.
[[gnu::always_inline]] inline std::uint64_t bits_of(const std::uint8_t* flags) {
  constexpr std::uint64_t kGather = 0x0102040810204080ULL;  // moves the lowest bit of byte n to bit 56 + n
  std::uint64_t bits = 0;
  for (int n = 0; n < kBrickVoxels / 8; ++n) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, flags + n * 8, sizeof eight);
    bits |= (eight * kGather >> 56) << (8 * n);
  }
  return bits;
}

}  // namespace panoptic::kernels
