// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A cell of free space in 32 bits: the evidence, and the ticks of both times plus one (0 = never).
#pragma once

#include <algorithm>
#include <cstdint>

#include "panoptic/free_space.h"

namespace panoptic {

inline constexpr std::uint32_t kMostTicks = (1U << 12) - 1;

constexpr int evidence_of(std::uint32_t cell) { return static_cast<std::int8_t>(cell >> 24); }
constexpr std::uint32_t empty_tick_of(std::uint32_t cell) { return cell & kMostTicks; }
constexpr std::uint32_t occupied_tick_of(std::uint32_t cell) { return cell >> 12 & kMostTicks; }

constexpr std::uint32_t cell_with(int evidence, std::uint32_t empty_tick, std::uint32_t occupied_tick) {
  return static_cast<std::uint32_t>(static_cast<std::uint8_t>(evidence)) << 24 | occupied_tick << 12 | empty_tick;
}

constexpr std::uint32_t seen_empty(std::uint32_t cell, std::uint32_t tick) {
  return cell_with(std::min(evidence_of(cell) + 1, kMostEmpty), tick, occupied_tick_of(cell));
}

constexpr std::uint32_t seen_occupied(std::uint32_t cell, std::uint32_t tick) {
  const int before = evidence_of(cell);
  return cell_with(std::max((before > 0 ? before / 2 : before) - 2, -kMostOccupied), empty_tick_of(cell), tick);
}

// With ticks twice as long.
constexpr std::uint32_t with_halved_times(std::uint32_t cell) {
  const auto halved = [](std::uint32_t tick) { return (tick + 1) / 2; };
  return cell_with(evidence_of(cell), halved(empty_tick_of(cell)), halved(occupied_tick_of(cell)));
}

// A cell without evidence was once seen to be empty and once not.
constexpr Space space_of(std::uint32_t cell) {
  if (cell == 0) return Space::kUnknown;
  return evidence_of(cell) > 0 ? Space::kFree : Space::kOccupied;
}

// The voxel block that a cell lies in, and the number of the cell there.
constexpr BlockIndex block_of(const CellIndex& cell) { return {cell[0] >> 2, cell[1] >> 2, cell[2] >> 2}; }
constexpr int number_of(const CellIndex& cell) { return (cell[0] & 3) | (cell[1] & 3) << 2 | (cell[2] & 3) << 4; }

// The chunk of a voxel block, and the number of the block there; the n-th block of a chunk.
constexpr BlockIndex chunk_of(BlockIndex block) { return {block.x >> 2, block.y >> 2, block.z >> 2}; }
constexpr int number_of(BlockIndex block) { return (block.x & 3) | (block.y & 3) << 2 | (block.z & 3) << 4; }
constexpr BlockIndex block_in(BlockIndex chunk, int number) {
  return {chunk.x * 4 + (number & 3), chunk.y * 4 + (number >> 2 & 3), chunk.z * 4 + (number >> 4)};
}

}  // namespace panoptic
