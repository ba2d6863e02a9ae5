// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/surface.h"

#include <algorithm>
#include <utility>

#include "panoptic/map/block_key.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/meshing/weld.h"

namespace panoptic {

SnapshotSurface::SnapshotSurface(std::shared_ptr<const Snapshot> snapshot) : snapshot_(std::move(snapshot)) {
  const std::vector<SnapshotChunk>& chunks = snapshot_->chunks;
  chunk_at_.reserve(chunks.size());
  for (std::size_t i = 0; i < chunks.size(); ++i) chunk_at_.emplace(pack(chunks[i].index), i);
  versions_.reserve(chunks.size());
  for (const SnapshotChunk& chunk : chunks) {
    std::uint64_t newest = chunk.version;
    for (int n = 0; n < kNeighbours; ++n) {
      const std::size_t found = find(neighbour(chunk.index, n));
      if (found != kNoChunk) newest = std::max(newest, chunks[found].version);
    }
    versions_.push_back(newest);
  }
}

std::size_t SnapshotSurface::find(BlockIndex index) const {
  if (!in_range(index)) return kNoChunk;
  const auto found = chunk_at_.find(pack(index));
  return found == chunk_at_.end() ? kNoChunk : found->second;
}

std::vector<Vec3f> SnapshotSurface::normals(std::size_t chunk) const {
  const SnapshotChunk& own = snapshot_->chunks[chunk];
  const std::vector<ChunkVertex>& vertices = own.surface->vertices;
  std::vector<Vec3f> sums(vertices.size(), Vec3f::Zero());
  std::unordered_map<GridEdge, std::uint32_t, GridEdgeHash> border;
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    if (on_border(vertices[i])) {
      border.emplace(grid_edge(own.index, vertices[i]), i);
    } else {
      sums[i] = vertices[i].area_normal;
    }
  }
  // Sums run in the same order from whichever of the chunks, so that they are equal bit for bit.
  for (int n = 0; n < kNeighbours && !border.empty(); ++n) {
    const BlockIndex index = neighbour(own.index, n);
    const std::size_t found = find(index);
    if (found == kNoChunk) continue;
    for (const ChunkVertex& v : snapshot_->chunks[found].surface->vertices) {
      if (!on_border(v)) continue;
      const auto at = border.find(grid_edge(index, v));
      if (at != border.end()) sums[at->second] += v.area_normal;
    }
  }
  for (Vec3f& sum : sums) sum = unit_normal(sum);
  return sums;
}

Mesh SnapshotSurface::assemble(const LabelSet& labels) const {
  std::unordered_map<PanopticId, ClassId> class_of;
  for (const SnapshotObject& object : snapshot_->objects) class_of[object.id] = object.class_id;
  std::vector<PlacedChunk> placed;
  for (const SnapshotChunk& chunk : snapshot_->chunks) placed.push_back({chunk.index, chunk.surface.get()});
  Mesh mesh = weld(placed);
  for (MeshVertex& v : mesh.vertices) {
    const auto object = class_of.find(v.panoptic_id);
    const ClassId of_stuff = labels.is_object(v.panoptic_id) ? ClassId::kUnknown : static_cast<ClassId>(number(v.panoptic_id));
    v.class_id = object == class_of.end() ? of_stuff : object->second;
  }
  return mesh;
}

}  // namespace panoptic
