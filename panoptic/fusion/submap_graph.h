// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A submap as a graph: a copy of what the CRF needs to know of its voxels, so that it can be solved while the map goes on.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/fusion/frame_votes.h"
#include "panoptic/fusion/mean_field.h"
#include "panoptic/map/voxel_map.h"

namespace panoptic {

struct GatherSettings {
  float band_m = 0.096F;              // voxels farther than this from the surface are left out
  int halo_voxels = 8;                // 1..16: how far the graph reaches beyond the submap
  float highest_probability = 0.99F;  // p of Eq. 19 is held below this
};

// A voxel of the submap itself, as it was when it was copied.
struct CoreVoxel {
  std::uint32_t node;
  Slot slot;
  std::uint16_t voxel;  // within the block
  VoxelLabel held;
  VoxelLabel voted;  // by frames, FrameVotes tells how: what the graph knows of it
  float weight;      // W^D
  float vote_sum;    // W^V; 0: frames never voted, and the graph knows nothing of it
};

struct SubmapGraph {
  std::vector<Slot> blocks;
  std::uint64_t epoch = 0;      // the map's when it was copied
  std::vector<CoreVoxel> core;  // the halo has nodes in the graph, but is not here
  CrfGraph graph;
  std::vector<std::uint16_t> ids;             // label slot by label of the graph
  PanopticId next_id = PanopticId::kUnknown;  // the registry's when it was copied; for who takes slots for objects, nothing here
};

// Observed voxels of the blocks and of a halo around them, with what frames voted for. The labels are those that the graph's
// voxels were voted for, and unknown if there are voxels without a vote; if there are more than kMostLabels, the most frequent
// ones (of equally frequent ones the lower), and voxels with others keep theirs.
SubmapGraph gather_submap(const VoxelMap& map, const FrameVotes& votes, std::span<const Slot> blocks,
                          const GatherSettings& settings);

inline constexpr std::size_t kMostLabels = 256;

}  // namespace panoptic
