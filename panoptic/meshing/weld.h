// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks put together where they meet: a vertex on a border of blocks is in the chunk of each of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "panoptic/map/block_key.h"
#include "panoptic/meshing/mesher.h"

namespace panoptic {

// True if chunks of other blocks may have the vertex too.
bool on_border(const ChunkVertex& v);

// A grid edge of the whole map, the same from whichever chunk it is seen: it belongs to the block that holds its lower corner.
struct GridEdge {
  std::uint64_t block;
  std::uint32_t edge;

  bool operator==(const GridEdge&) const = default;
};
struct GridEdgeHash {
  std::size_t operator()(const GridEdge& e) const { return mixed(e.block * 31 + e.edge); }
};
GridEdge grid_edge(BlockIndex block, const ChunkVertex& v);

// The vector at length 1; upwards along z if it has no direction.
Vec3f unit_normal(const Vec3f& v);

struct PlacedChunk {
  BlockIndex block;
  const MeshChunk* chunk = nullptr;
};

// The chunks as one mesh: no vertex twice, unit normals. It knows no classes; they are left unknown.
Mesh weld(std::span<const PlacedChunk> chunks);

}  // namespace panoptic
