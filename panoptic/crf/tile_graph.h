// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A tile as a graph: a copy of what the CRF needs to know of its voxels, so that it can be solved while the map goes on.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/crf/mean_field.h"
#include "panoptic/labels.h"
#include "panoptic/map/frame_votes.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

struct GatherSettings {
  float band_m = 0.096F;              // voxels farther than this from the surface are left out
  int halo_voxels = 8;                // 1..16: how far the graph reaches beyond the tile
  float highest_probability = 0.99F;  // p of Eq. 19 is held below this
};

// A voxel of the tile itself, as it was when it was copied.
struct CoreVoxel {
  std::uint32_t node;
  Slot slot;
  std::uint16_t voxel;  // within the block
  VoxelLabel held;
  VoxelLabel voted;  // by frames, FrameVotes tells how: what the graph knows of it
  float weight;      // W^D
  float vote_sum;    // W^V; 0: frames never voted, and the graph knows nothing of it
};

struct TileGraph {
  std::vector<Slot> blocks;
  std::uint64_t epoch = 0;      // the map's when it was copied
  std::vector<CoreVoxel> core;  // the halo has nodes in the graph, but is not here
  CrfGraph graph;
  std::vector<std::uint16_t> ids;             // label slot by label of the graph
  PanopticId next_id = PanopticId::kUnknown;  // the registry's when it was copied; for who takes slots for objects, nothing here
};

// Copies the observed voxels of the blocks and of a halo around them, with the frames' votes. The graph's labels are those that
// its voxels were voted for, and unknown if there are voxels without a vote. If there are more than kMostLabels, the most
// frequent ones are taken (of equally frequent ones the lower), and voxels with others keep theirs.
TileGraph gather_tile(const VoxelMap& map, const FrameVotes& votes, std::span<const Slot> blocks, const GatherSettings& settings);

inline constexpr std::size_t kMostLabels = 256;

}  // namespace panoptic
