// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One observation each for 16 voxels, property by property (Eq. 6-11). For use inside functions with PANOPTIC_CLONES only, into
// which all of it is inlined: plain arrays and nothing but ternaries in the loops, so that each loop vectorises by itself.
#pragma once

#include <cstddef>
#include <cstdint>

#include "panoptic/fusion/integrate_kernels.h"

namespace panoptic::kernels {

constexpr int kRow = kBlockSide;

// The rules by which voxels take up an observation.
struct RowRules {
  LabelVotes votes;
  float max_weight = 0;
};

// The observations for 16 voxels.
struct RowScratch {
  alignas(64) float distance[kRow];
  alignas(64) float weight[kRow];      // of the observation; 0 = none
  alignas(64) float old_weight[kRow];  // of the voxel
  alignas(64) std::uint32_t color[kRow];
  alignas(64) std::int32_t label[kRow];
};

[[gnu::always_inline]] inline void fuse_distances(VoxelBlock& block, std::size_t first, float max_weight, RowScratch& s) {
  float* __restrict distance = block.distance.data() + first;
  float* __restrict weight = block.weight.data() + first;
  for (int k = 0; k < kRow; ++k) {
    const float old_weight = weight[k];
    const float fused = fused_distance(distance[k], old_weight, s.distance[k], s.weight[k]);
    distance[k] = s.weight[k] > 0 ? fused : distance[k];
    weight[k] = fused_weight(old_weight, s.weight[k], max_weight);
    s.old_weight[k] = old_weight;
  }
}

// 16-bit planes are worked in 32 bits, the width of everything else: GCC vectorises mixed widths badly.
[[gnu::always_inline]] inline void fuse_channel(std::uint16_t* plane, int shift, const RowScratch& s) {
  alignas(64) std::int32_t value[kRow];
  for (int k = 0; k < kRow; ++k) value[k] = plane[k];
  for (int k = 0; k < kRow; ++k) {
    const bool use = (s.weight[k] > 0) & (s.color[k] != 0);
    const auto color = static_cast<std::int32_t>(s.color[k] >> shift & 0xFFU);
    const std::int32_t fused = fused_color(value[k], s.old_weight[k], color, s.weight[k]);
    value[k] = use ? fused : value[k];
  }
  for (int k = 0; k < kRow; ++k) plane[k] = static_cast<std::uint16_t>(value[k]);
}

[[gnu::always_inline]] inline void fuse_labels(VoxelBlock& block, std::size_t first, const RowRules& rules, const RowScratch& s) {
  alignas(64) std::int32_t label[kRow];
  std::uint16_t* __restrict plane = block.label.data() + first;
  float* __restrict label_weight = block.label_weight.data() + first;
  float* __restrict vote_sum = block.vote_sum.data() + first;
  for (int k = 0; k < kRow; ++k) label[k] = plane[k];
  for (int k = 0; k < kRow; ++k) {
    const bool use = (s.weight[k] > 0) & (s.label[k] != number(LabelSlot::kNoVote));
    const VoxelVotes old{{static_cast<std::uint16_t>(label[k]), label_weight[k]}, vote_sum[k]};
    const auto observed = static_cast<std::uint16_t>(s.label[k]);
    const VoxelVotes fused = fused_votes(old, observed, s.weight[k] * rules.votes.of(observed), rules.max_weight);
    label[k] = use ? fused.label.label : label[k];
    label_weight[k] = use ? fused.label.weight : label_weight[k];
    vote_sum[k] = use ? fused.sum : vote_sum[k];
  }
  for (int k = 0; k < kRow; ++k) plane[k] = static_cast<std::uint16_t>(label[k]);
}

// Fuses the row of 16 voxels that begins at voxel `first` of the block.
[[gnu::always_inline]] inline void fuse_row(VoxelBlock& block, std::size_t first, const RowRules& rules, RowScratch& s) {
  fuse_distances(block, first, rules.max_weight, s);
  fuse_channel(block.red.data() + first, 16, s);
  fuse_channel(block.green.data() + first, 8, s);
  fuse_channel(block.blue.data() + first, 0, s);
  fuse_labels(block, first, rules, s);
}

}  // namespace panoptic::kernels
