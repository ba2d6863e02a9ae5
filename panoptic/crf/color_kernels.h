// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of ColorFilter, compiled for several instruction sets.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "panoptic/crf/grid_filter.h"

namespace panoptic {

struct ClusterPair {
  std::uint32_t cluster;
  float weight;
};

namespace kernels {

struct PairWork {
  std::array<const float*, 6> axes;  // of the candidates: a pair's weight is e^-(squared difference)
  const std::uint32_t* clusters;     // of the candidates
  std::size_t count;                 // of the candidates, a multiple of sixteen
  std::array<float, 6> center;       // of the cluster
  float farthest;                    // squared differences from here on are left out
  std::uint32_t* near;               // room for one a candidate, as below: clusters
  float* weights;
  ClusterPair* found;
};

// Returns how many pairs were found.
std::size_t find_pairs(const PairWork& work);

// Rows of sums, each over a part of a list: `ends` tells where the parts end, the first one begins at `begin`.
struct RowSums {
  std::span<const std::uint32_t> ends;
  std::size_t begin;
  float* out;
};
// The list: rows of voxels, with their scale.
struct MemberSums {
  RowSums rows;
  const std::uint32_t* members = nullptr;
  std::size_t count = 0;  // of the whole list
  ScaledRows in = {};
};
// The list: rows of clusters, with the weight of the pair.
struct PairSums {
  RowSums rows;
  const ClusterPair* pairs = nullptr;
  const float* in = nullptr;
};

void sum_members(const MemberSums& work, RowWidth width);
void sum_pairs(const PairSums& work, RowWidth width);

}  // namespace kernels
}  // namespace panoptic
