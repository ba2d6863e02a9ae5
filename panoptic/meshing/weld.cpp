// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/meshing/weld.h"

#include <limits>
#include <utility>

namespace panoptic {

bool on_border(const ChunkVertex& v) {
  const auto border = [](std::uint8_t c) { return c == 0 || c == kBlockSide; };
  return border(v.corner_x) || border(v.corner_y) || border(v.corner_z);
}

GridEdge grid_edge(BlockIndex block, const ChunkVertex& v) {
  block.x += v.corner_x / kBlockSide;
  block.y += v.corner_y / kBlockSide;
  block.z += v.corner_z / kBlockSide;
  const auto voxel = voxel_offset(v.corner_x % kBlockSide, v.corner_y % kBlockSide, v.corner_z % kBlockSide);
  return {pack(block), static_cast<std::uint32_t>(voxel) * 3 + v.axis};
}

Vec3f unit_normal(const Vec3f& v) {
  const float length = v.norm();
  return length > 0 && length < std::numeric_limits<float>::infinity() ? Vec3f(v / length) : Vec3f::UnitZ();
}

void Welder::expect(std::size_t vertices, std::size_t triangles) {
  mesh_.vertices.reserve(vertices);
  mesh_.triangles.reserve(triangles);
}

void Welder::add(const PlacedChunk& placed) {
  const auto& [block, chunk] = placed;
  place_.clear();
  for (const ChunkVertex& v : chunk->vertices) {
    auto at = static_cast<std::uint32_t>(mesh_.vertices.size());
    if (on_border(v)) at = border_.try_emplace(grid_edge(block, v), at).first->second;
    place_.push_back(at);
    if (at < mesh_.vertices.size()) {
      mesh_.vertices[at].normal += v.area_normal;
    } else {
      mesh_.vertices.push_back({v.position, v.area_normal, v.color, ClassId::kUnknown, v.panoptic_id});
    }
  }
  for (const auto& t : chunk->triangles) mesh_.triangles.push_back({place_[t[0]], place_[t[1]], place_[t[2]]});
}

Mesh Welder::take() {
  for (MeshVertex& v : mesh_.vertices) v.normal = unit_normal(v.normal);
  border_.clear();
  return std::move(mesh_);
}

Mesh weld(std::span<const PlacedChunk> chunks) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (const PlacedChunk& placed : chunks) {
    vertices += placed.chunk->vertices.size();
    triangles += placed.chunk->triangles.size();
  }
  Welder welder;
  welder.expect(vertices, triangles);
  for (const PlacedChunk& placed : chunks) welder.add(placed);
  return welder.take();
}

}  // namespace panoptic
