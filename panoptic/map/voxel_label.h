// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The label of a voxel and what one more vote does to it (Eq. 9-11 of the paper).
#pragma once

#include <cstdint>

namespace panoptic {

struct VoxelLabel {
  std::uint16_t label;
  float weight;
};

// Eq. 9-11: agree and gain weight, disagree and lose weight, flip when the observation outweighs the memory.
inline VoxelLabel fused_label(VoxelLabel old, std::uint16_t label, float weight) {
  const bool same = old.label == label;
  const bool flip = !same & (weight > old.weight);
  const float gain = same ? old.weight + weight : old.weight - weight;
  return {flip ? label : old.label, flip ? weight - old.weight : gain};
}

// The label of a voxel with the weights of its votes.
struct VoxelVotes {
  VoxelLabel label;
  float sum;  // W^V
};

// Adds a vote for this label. Beyond the limit all votes fade alike, so that the share W^L / W^V stays. A label never weighs
// more than all votes.
inline VoxelVotes fused_votes(VoxelVotes old, std::uint16_t label, float weight, float max_weight) {
  const VoxelLabel fused = fused_label(old.label, label, weight);
  const float sum = old.sum + weight;
  const float kept = fused.weight * (sum > max_weight ? max_weight / sum : 1.0F);
  return {{fused.label, kept > max_weight ? max_weight : kept}, sum > max_weight ? max_weight : sum};
}

}  // namespace panoptic
