// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of MeanField, compiled for several instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "panoptic/crf/grid_filter.h"

namespace panoptic {

// Columns whose values lie side by side, `stride` apart from voxel to voxel.
struct ColumnGroup {
  float* rows;
  std::size_t stride;
  std::size_t columns;    // 8 or 16
  const float* is_label;  // 1 for a column of labels, 0 for what only fills the group
};

namespace kernels {

// The input of messages: the kernels' sums, and the voxels' own marginals, in whose place the messages come.
struct MessageWork {
  std::span<const std::uint32_t> voxels;
  const float* grid_sums;           // a row for each of them
  const float* color_sums;          // by cluster
  const std::uint32_t* cluster_of;  // by voxel, as all below
  const float* color_norm;
  const float* grid_norm;
  float w1;
  float w2;
  float* rows;
};

// The step from messages to marginals: a column's logit is its message, and for the voxel's own label the head start on top of
// it. `absent` labels without a column have a logit of 0. If there are any, rows hold how much more probable a column is than
// they are: that difference is all that messages need to be made of.
struct MarginalWork {
  std::span<const ColumnGroup> groups;
  const std::int32_t* own_column;  // by voxel; -1: none
  const float* head_start;         // by voxel
  float absent;
};

// Writes messages in the place of marginals.
void combine_rows(const MessageWork& work, RowWidth width);
// Writes marginals in the place of messages.
void softmax_rows(const MarginalWork& work, std::span<const std::uint32_t> voxels);
// Does both at once, where a row has all columns, to the same bits.
void renew_rows(const MessageWork& messages, const MarginalWork& marginals, RowWidth width);

}  // namespace kernels
}  // namespace panoptic
