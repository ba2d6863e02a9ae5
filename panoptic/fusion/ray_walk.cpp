// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/ray_walk.h"

#include <limits>

#include "panoptic/base/clones.h"
#include "panoptic/base/floor.h"

namespace panoptic {
namespace kernels {

struct WalkState {
  alignas(64) std::int32_t cell[3][kWalkLanes];
  alignas(64) std::int32_t step[3][kWalkLanes];
  alignas(64) float next[3][kWalkLanes];
  alignas(64) float delta[3][kWalkLanes];
};

void walk_lanes(CellWalks& walks);

[[gnu::always_inline]] static inline void set_out(CellWalks& walks, WalkState& s) {
  constexpr float kNever = std::numeric_limits<float>::max();
  for (std::int32_t& count : walks.count) count = 1;
  for (int a = 0; a < 3; ++a) {
    for (std::size_t k = 0; k < kWalkLanes; ++k) {
      const float start = walks.start[a][k];
      const float length = walks.end[a][k] - start;
      const std::int32_t first = floor_to_int(start);
      const std::int32_t apart = floor_to_int(walks.end[a][k]) - first;
      const float border = static_cast<float>(first) + (length > 0 ? 1.0F : 0.0F);
      const float to_border = (border - start) / length;
      const float per_cell = 1.0F / (length < 0 ? -length : length);
      s.cell[a][k] = first;
      s.step[a][k] = length > 0 ? 1 : -1;
      s.next[a][k] = length != 0 ? to_border : kNever;
      s.delta[a][k] = length != 0 ? per_cell : kNever;
      walks.count[k] += apart < 0 ? -apart : apart;
    }
  }
}

// The offsets of the cells of one step, and whether they left a block.
[[gnu::always_inline]] static inline void note_blocks(CellWalks& walks, std::size_t i) {
  const std::size_t before = i == 0 ? 0 : i - 1;
  const std::int32_t* __restrict x = walks.cell[0][i];
  const std::int32_t* __restrict y = walks.cell[1][i];
  const std::int32_t* __restrict z = walks.cell[2][i];
  std::uint16_t* __restrict offset = walks.offset[i];
  std::uint32_t* __restrict borders = walks.borders[i / 32];
  for (std::size_t k = 0; k < kWalkLanes; ++k) {
    offset[k] = static_cast<std::uint16_t>((x[k] & 15) | (y[k] & 15) << 4 | (z[k] & 15) << 8);
  }
  for (std::size_t k = 0; k < kWalkLanes; ++k) {
    const std::int32_t moved =
        (x[k] ^ walks.cell[0][before][k]) | (y[k] ^ walks.cell[1][before][k]) | (z[k] ^ walks.cell[2][before][k]);
    const std::uint32_t left = (moved & ~15) != 0 ? 1U : 0U;
    borders[k] = (i % 32 == 0 ? 0U : borders[k]) | left << (i % 32);
  }
}

// Which axis is next is as good as random, so a walk alone pays for a wrong guess of the CPU at every other step.
PANOPTIC_CLONES
void walk_lanes(CellWalks& walks) {
  WalkState s;                                      // NOLINT(cppcoreguidelines-pro-type-member-init): set_out fills it
  alignas(64) std::int32_t on_axis[3][kWalkLanes];  // all bits where the next border lies on this axis
  set_out(walks, s);
  std::int32_t longest = 1;
  for (const std::int32_t count : walks.count) longest = count > longest ? count : longest;
  const std::size_t cells = longest < static_cast<std::int32_t>(kMostCells) ? static_cast<std::size_t>(longest) : kMostCells;
  for (std::size_t i = 0; i < cells; ++i) {
    for (std::size_t k = 0; k < kWalkLanes; ++k) {
      const std::int32_t x_before_y = s.next[0][k] <= s.next[1][k] ? -1 : 0;
      const std::int32_t x_before_z = s.next[0][k] <= s.next[2][k] ? -1 : 0;
      const std::int32_t y_before_z = s.next[1][k] <= s.next[2][k] ? -1 : 0;
      const std::int32_t on_x = x_before_y & x_before_z;
      const std::int32_t on_y = ~x_before_y & y_before_z;
      on_axis[0][k] = on_x;
      on_axis[1][k] = on_y;
      on_axis[2][k] = ~(on_x | on_y);
    }
    for (int a = 0; a < 3; ++a) {
      std::int32_t* __restrict cell = walks.cell[a][i];
      for (std::size_t k = 0; k < kWalkLanes; ++k) cell[k] = s.cell[a][k];
      for (std::size_t k = 0; k < kWalkLanes; ++k) s.cell[a][k] += s.step[a][k] & on_axis[a][k];
      for (std::size_t k = 0; k < kWalkLanes; ++k) {
        const float moved = s.next[a][k] + s.delta[a][k];
        s.next[a][k] = on_axis[a][k] != 0 ? moved : s.next[a][k];
      }
    }
    note_blocks(walks, i);
  }
}

}  // namespace kernels

void walk_together(CellWalks& walks) { kernels::walk_lanes(walks); }

}  // namespace panoptic
