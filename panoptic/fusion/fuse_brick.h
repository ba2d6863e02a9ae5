// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One observation each for the stored voxels of a brick, property by property (Eq. 6-11). For use inside functions with
// PANOPTIC_CLONES only, into which all of it is inlined: plain arrays and nothing but ternaries in the loops, so that each loop
// vectorises by itself.
#pragma once

#include <cstdint>

#include "panoptic/fusion/integrate_kernels.h"

namespace panoptic::kernels {

// The rules by which voxels take up an observation.
struct FusionRules {
  LabelVotes votes;
  float max_weight = 0;
};

// The observations, in the order in which the brick stores its voxels, as many as it has capacity for.
struct BrickObservations {
  alignas(64) float distance[kBrickVoxels];
  alignas(64) float weight[kBrickVoxels];      // of the observation; 0 = none
  alignas(64) float old_weight[kBrickVoxels];  // of the voxel
  alignas(64) std::uint32_t color[kBrickVoxels];
  alignas(64) std::int32_t label[kBrickVoxels];
};

[[gnu::always_inline]] inline void fuse_distances(Brick& brick, int count, float max_weight, BrickObservations& o) {
  float* __restrict distance = brick.plane(FloatPlane::kDistance);
  float* __restrict weight = brick.plane(FloatPlane::kWeight);
  for (int k = 0; k < count; ++k) {
    const float old_weight = weight[k];
    const float fused = fused_distance(distance[k], old_weight, o.distance[k], o.weight[k]);
    distance[k] = o.weight[k] > 0 ? fused : distance[k];
    weight[k] = fused_weight(old_weight, o.weight[k], max_weight);
    o.old_weight[k] = old_weight;
  }
}

// 16-bit planes are worked in 32 bits, the width of everything else: GCC vectorises mixed widths badly.
[[gnu::always_inline]] inline void fuse_channel(std::uint16_t* plane, int count, int shift, const BrickObservations& o) {
  alignas(64) std::int32_t value[kBrickVoxels];
  for (int k = 0; k < count; ++k) value[k] = plane[k];
  for (int k = 0; k < count; ++k) {
    const bool use = (o.weight[k] > 0) & (o.color[k] != 0);
    const auto color = static_cast<std::int32_t>(o.color[k] >> shift & 0xFFU);
    const std::int32_t fused = fused_color(value[k], o.old_weight[k], color, o.weight[k]);
    value[k] = use ? fused : value[k];
  }
  for (int k = 0; k < count; ++k) plane[k] = static_cast<std::uint16_t>(value[k]);
}

[[gnu::always_inline]] inline void fuse_labels(Brick& brick, int count, const FusionRules& rules, const BrickObservations& o) {
  alignas(64) std::int32_t label[kBrickVoxels];
  std::uint16_t* __restrict plane = brick.plane(WordPlane::kLabel);
  float* __restrict label_weight = brick.plane(FloatPlane::kLabelWeight);
  float* __restrict vote_sum = brick.plane(FloatPlane::kVoteSum);
  for (int k = 0; k < count; ++k) label[k] = plane[k];
  for (int k = 0; k < count; ++k) {
    const bool use = (o.weight[k] > 0) & (o.label[k] != number(LabelSlot::kNoVote));
    const VoxelVotes old{{static_cast<std::uint16_t>(label[k]), label_weight[k]}, vote_sum[k]};
    const auto observed = static_cast<std::uint16_t>(o.label[k]);
    const VoxelVotes fused = fused_votes(old, observed, o.weight[k] * rules.votes.of(observed), rules.max_weight);
    label[k] = use ? fused.label.label : label[k];
    label_weight[k] = use ? fused.label.weight : label_weight[k];
    vote_sum[k] = use ? fused.sum : vote_sum[k];
  }
  for (int k = 0; k < count; ++k) plane[k] = static_cast<std::uint16_t>(label[k]);
}

[[gnu::always_inline]] inline void fuse_brick(Brick& brick, int count, const FusionRules& rules, BrickObservations& o) {
  fuse_distances(brick, count, rules.max_weight, o);
  fuse_channel(brick.plane(WordPlane::kRed), count, 16, o);
  fuse_channel(brick.plane(WordPlane::kGreen), count, 8, o);
  fuse_channel(brick.plane(WordPlane::kBlue), count, 0, o);
  fuse_labels(brick, count, rules, o);
}

}  // namespace panoptic::kernels
