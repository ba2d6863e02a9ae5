// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The place of a voxel block: integer coordinates on the grid of blocks.
#pragma once

#include <cstdint>

#include "panoptic/voxel_map.h"

namespace panoptic {

// One key per block, in the order of (z, y, x).
constexpr std::uint64_t pack(BlockIndex i) {
  const auto bits = [](std::int32_t c) { return static_cast<std::uint64_t>(std::int64_t{c} + (1 << 20)); };
  return bits(i.z) << 42 | bits(i.y) << 21 | bits(i.x);
}

constexpr BlockIndex unpack(std::uint64_t key) {
  const auto coordinate = [&](int shift) { return static_cast<std::int32_t>(key >> shift & 0x1FFFFF) - (1 << 20); };
  return {coordinate(0), coordinate(21), coordinate(42)};
}

// Packed keys of neighbours differ in few bits; a table indexed by them unmixed degenerates into long probes.
constexpr std::uint64_t mixed(std::uint64_t key) {
  key ^= key >> 32;
  key *= 0xD6E8FEB86659FD93ULL;
  key ^= key >> 32;
  return key;
}

}  // namespace panoptic
