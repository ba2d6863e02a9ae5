// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The effect of one observation on one voxel, written plainly (Eq. 6-11).
#pragma once

#include <cstdint>

#include "panoptic/fusion/integrate_kernels.h"
#include "panoptic/voxel_block.h"

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

}  // namespace panoptic::test
