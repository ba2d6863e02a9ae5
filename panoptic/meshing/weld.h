// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks put together where they meet: a vertex on a border of blocks is in the chunk of each of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

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

// Puts chunks together one after the other, so that whoever makes them need not keep them.
class Welder {
 public:
  // Takes room for a mesh of so many; more may come.
  void expect(std::size_t vertices, std::size_t triangles);
  void add(const PlacedChunk& placed);
  bool has_room(std::size_t vertices, std::size_t triangles) const {
    return vertices <= mesh_.vertices.capacity() && triangles <= mesh_.triangles.capacity();
  }
  std::size_t vertices() const { return mesh_.vertices.size(); }
  std::size_t triangles() const { return mesh_.triangles.size(); }
  // No vertex twice, unit normals. It knows no classes; they are left unknown. The welder is spent.
  Mesh take();

 private:
  Mesh mesh_;
  std::unordered_map<GridEdge, std::uint32_t, GridEdgeHash> border_;
  std::vector<std::uint32_t> place_;  // of the vertices of a chunk
};

// All chunks as one mesh.
Mesh weld(std::span<const PlacedChunk> chunks);

}  // namespace panoptic
