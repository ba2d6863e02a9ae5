// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The fusion of one voxel and the walk along one ray, as they read in the paper: what the kernels, which take many at a time, are
// tested against.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "panoptic/base/floor.h"
#include "panoptic/fusion/integrate_kernels.h"
#include "panoptic/geometry.h"

namespace panoptic::test {

// `color` as in RegisteredFrame.
struct VoxelUpdate {
  float distance;
  float weight;
  std::uint32_t color;
  LabelSlot label;
};

inline void fuse_voxel(Voxel& voxel, const VoxelUpdate& update, const LabelVotes& votes, float max_weight) {
  const float old_weight = voxel.weight;
  voxel.distance = fused_distance(voxel.distance, old_weight, update.distance, update.weight);
  voxel.weight = fused_weight(old_weight, update.weight, max_weight);
  if (update.color != 0) {
    const auto fuse = [&](std::uint16_t& channel, std::uint32_t value) {
      channel =
          static_cast<std::uint16_t>(fused_color(channel, old_weight, static_cast<std::int32_t>(value & 0xFFU), update.weight));
    };
    fuse(voxel.red, update.color >> 16);
    fuse(voxel.green, update.color >> 8);
    fuse(voxel.blue, update.color);
  }
  if (update.label != LabelSlot::kNoVote) {
    const VoxelVotes old{{voxel.label, voxel.label_weight}, voxel.vote_sum};
    const VoxelVotes fused = fused_votes(old, number(update.label), update.weight * votes.of(number(update.label)), max_weight);
    voxel.label = fused.label.label;
    voxel.label_weight = fused.label.weight;
    voxel.vote_sum = fused.sum;
  }
}

// Calls visit(x, y, z) for every cell of the unit grid that the segment from `start` to `end` passes through, start cell first.
// REQUIRES coordinates within the range of int32.
template <typename Visit>
void walk_cells(const Vec3f& start, const Vec3f& end, Visit&& visit) {
  std::int32_t cell[3];
  std::int32_t step[3];
  float next[3];   // path parameter (0..1) at which the next cell border on this axis is crossed
  float delta[3];  // path parameter per cell
  int steps = 0;
  for (int a = 0; a < 3; ++a) {
    const float length = end[a] - start[a];
    cell[a] = floor_to_int(start[a]);
    steps += std::abs(floor_to_int(end[a]) - cell[a]);
    step[a] = length > 0 ? 1 : -1;
    const float border = static_cast<float>(cell[a]) + (length > 0 ? 1.0F : 0.0F);
    next[a] = length != 0 ? (border - start[a]) / length : std::numeric_limits<float>::max();
    delta[a] = length != 0 ? 1.0F / std::abs(length) : std::numeric_limits<float>::max();
  }
  visit(cell[0], cell[1], cell[2]);
  for (int i = 0; i < steps; ++i) {
    const int axis = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    cell[axis] += step[axis];
    next[axis] += delta[axis];
    visit(cell[0], cell[1], cell[2]);
  }
}

}  // namespace panoptic::test
