// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/surface.h"

#include <algorithm>
#include <utility>

#include "panoptic/map/block_key.h"
#include "panoptic/voxel_map.h"

namespace panoptic {
namespace {

constexpr int kNeighbourhood = 27;

// The n-th block of the neighbourhood, itself in the middle; ascending coordinates.
BlockIndex neighbour(BlockIndex block, int n) { return {block.x + n % 3 - 1, block.y + n / 3 % 3 - 1, block.z + n / 9 - 1}; }

bool on_border(const ChunkVertex& v) {
  const auto border = [](std::uint8_t c) { return c == 0 || c == kBlockSide; };
  return border(v.corner_x) || border(v.corner_y) || border(v.corner_z);
}

// A grid edge of the whole map, the same from whichever chunk it is seen: it belongs to the block that holds its lower corner.
struct GridEdge {
  std::uint64_t block;
  std::uint32_t edge;

  bool operator==(const GridEdge&) const = default;
};
struct GridEdgeHash {
  std::size_t operator()(const GridEdge& e) const { return mixed(e.block * 31 + e.edge); }
};
using VertexAtEdge = std::unordered_map<GridEdge, std::uint32_t, GridEdgeHash>;

GridEdge grid_edge(BlockIndex block, const ChunkVertex& v) {
  block.x += v.corner_x / kBlockSide;
  block.y += v.corner_y / kBlockSide;
  block.z += v.corner_z / kBlockSide;
  const auto voxel = voxel_offset(v.corner_x % kBlockSide, v.corner_y % kBlockSide, v.corner_z % kBlockSide);
  return {pack(block), static_cast<std::uint32_t>(voxel) * 3 + v.axis};
}

Vec3f unit(const Vec3f& v) {
  const float length = v.norm();
  return length > 0 && length < std::numeric_limits<float>::infinity() ? Vec3f(v / length) : Vec3f::UnitZ();
}

}  // namespace

SnapshotSurface::SnapshotSurface(std::shared_ptr<const Snapshot> snapshot) : snapshot_(std::move(snapshot)) {
  const std::vector<SnapshotChunk>& chunks = snapshot_->chunks;
  chunk_at_.reserve(chunks.size());
  for (std::size_t i = 0; i < chunks.size(); ++i) chunk_at_.emplace(pack(chunks[i].index), i);
  versions_.reserve(chunks.size());
  for (const SnapshotChunk& chunk : chunks) {
    std::uint64_t newest = chunk.version;
    for (int n = 0; n < kNeighbourhood; ++n) {
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
  VertexAtEdge border;
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    if (on_border(vertices[i])) {
      border.emplace(grid_edge(own.index, vertices[i]), i);
    } else {
      sums[i] = vertices[i].area_normal;
    }
  }
  // Sums run in the same order from whichever of the chunks, so that they are equal bit for bit.
  for (int n = 0; n < kNeighbourhood && !border.empty(); ++n) {
    const BlockIndex index = neighbour(own.index, n);
    const std::size_t found = find(index);
    if (found == kNoChunk) continue;
    for (const ChunkVertex& v : snapshot_->chunks[found].surface->vertices) {
      if (!on_border(v)) continue;
      const auto at = border.find(grid_edge(index, v));
      if (at != border.end()) sums[at->second] += v.area_normal;
    }
  }
  for (Vec3f& sum : sums) sum = unit(sum);
  return sums;
}

Mesh SnapshotSurface::assemble(const LabelSet& labels) const {
  std::unordered_map<PanopticId, ClassId> class_of;
  for (const SnapshotObject& object : snapshot_->objects) class_of[object.id] = object.class_id;
  Mesh mesh;
  VertexAtEdge border;
  std::vector<std::uint32_t> place;
  for (const SnapshotChunk& chunk : snapshot_->chunks) {
    place.clear();
    for (const ChunkVertex& v : chunk.surface->vertices) {
      auto at = static_cast<std::uint32_t>(mesh.vertices.size());
      if (on_border(v)) at = border.try_emplace(grid_edge(chunk.index, v), at).first->second;
      place.push_back(at);
      if (at < mesh.vertices.size()) {
        mesh.vertices[at].normal += v.area_normal;
        continue;
      }
      const auto object = class_of.find(v.panoptic_id);
      const ClassId of_stuff = labels.is_object(v.panoptic_id) ? ClassId::kUnknown : static_cast<ClassId>(number(v.panoptic_id));
      const ClassId class_id = object == class_of.end() ? of_stuff : object->second;
      mesh.vertices.push_back({v.position, v.area_normal, v.color, class_id, v.panoptic_id});
    }
    for (const auto& t : chunk.surface->triangles) mesh.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
  }
  for (MeshVertex& v : mesh.vertices) v.normal = unit(v.normal);
  return mesh;
}

}  // namespace panoptic
