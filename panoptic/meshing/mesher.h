// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of the map as a labelled mesh: marching cubes over the blocks that changed.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/map.h"
#include "panoptic/mesh.h"
#include "panoptic/options.h"

namespace panoptic {

Fields fields(MesherOptions& options);

// A vertex of a chunk. It lies on the grid edge that starts at `corner` and runs along `axis`; corner coordinates are those of
// voxels of the block, 16 = the first voxel of the next block. Equal edges are equal vertices, also across chunks.
struct ChunkVertex {
  Vec3f position;          // world, metres
  Vec3f area_normal;       // sum of the normals of the chunk's triangles around it, weighted by area
  PanopticId panoptic_id;  // of the voxel that is nearer, at the time when the chunk was made
  float weight;            // how well it was seen: the smaller W^D of the two voxels
  Rgb color;
  std::uint8_t corner_x, corner_y, corner_z, axis;
  std::uint8_t confidence;  // in the label: weight of the label / weight of the distance of that voxel, x 255, at most 255
};

// The triangles of the cells whose lowest corner is a voxel of one block.
struct MeshChunk {
  std::vector<ChunkVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

class Mesher {
 public:
  explicit Mesher(const MesherOptions& options) : options_(options) {}

  // Extracts the chunks of the blocks that changed since the last call and of the neighbours that look into them; blocks run in
  // parallel. A chunk that was empty and still is stays the same one. Returns how many were looked at. Ids are those of the
  // objects now: a slot changes hands only where voxels change, so that older chunks are right too.
  std::size_t update(const PanopticMap& map);

  // All chunks as one mesh with shared vertices (none twice at block borders), unit normals, and classes as the objects have
  // them now. REQUIRES an update since the map changed.
  Mesh assemble(const PanopticMap& map) const;

  const MesherOptions& options() const { return options_; }

  // Chunks by slot, never null. A chunk is immutable and is replaced when its block changed, so whoever shares one may read it
  // for ever, on any thread, and chunks at the same address are the same chunk.
  const std::vector<std::shared_ptr<const MeshChunk>>& chunks() const { return chunks_; }

 private:
  MesherOptions options_;
  std::vector<std::shared_ptr<const MeshChunk>> chunks_;
  std::uint64_t seen_epoch_ = 0;
};

// The chunk of one block. Only cells whose eight corners were observed with min_weight are meshed.
MeshChunk extract_chunk(const VoxelMap& map, const ObjectRegistry& objects, Slot slot, float min_weight);

}  // namespace panoptic
