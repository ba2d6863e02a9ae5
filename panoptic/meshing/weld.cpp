// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/meshing/weld.h"

#include <limits>
#include <unordered_map>
#include <vector>

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

Mesh weld(std::span<const PlacedChunk> chunks) {
  Mesh mesh;
  std::size_t vertex_count = 0;
  std::size_t triangle_count = 0;
  for (const PlacedChunk& placed : chunks) {
    vertex_count += placed.chunk->vertices.size();
    triangle_count += placed.chunk->triangles.size();
  }
  mesh.vertices.reserve(vertex_count);
  mesh.triangles.reserve(triangle_count);
  std::unordered_map<GridEdge, std::uint32_t, GridEdgeHash> border;
  std::vector<std::uint32_t> place;
  for (const auto& [block, chunk] : chunks) {
    place.clear();
    for (const ChunkVertex& v : chunk->vertices) {
      auto at = static_cast<std::uint32_t>(mesh.vertices.size());
      if (on_border(v)) at = border.try_emplace(grid_edge(block, v), at).first->second;
      place.push_back(at);
      if (at < mesh.vertices.size()) {
        mesh.vertices[at].normal += v.area_normal;
      } else {
        mesh.vertices.push_back({v.position, v.area_normal, v.color, ClassId::kUnknown, v.panoptic_id});
      }
    }
    for (const auto& t : chunk->triangles) mesh.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
  }
  for (MeshVertex& v : mesh.vertices) v.normal = unit_normal(v.normal);
  return mesh;
}

}  // namespace panoptic
