// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/meshing/mesher.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "panoptic/map/block_key.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

// The blocks whose cells have corners in this one: itself and its neighbours towards lower coordinates.
void add_with_lower_neighbours(const VoxelMap& map, BlockIndex index, std::vector<Slot>& slots) {
  for (int n = 0; n < 8; ++n) {
    const Slot slot = map.find_slot({index.x - (n & 1), index.y - (n >> 1 & 1), index.z - (n >> 2 & 1)});
    if (slot != VoxelMap::kNoSlot) slots.push_back(slot);
  }
}

bool on_border(const ChunkVertex& v) {
  const auto border = [](std::uint8_t c) { return c == 0 || c == kBlockSide; };
  return border(v.corner_x) || border(v.corner_y) || border(v.corner_z);
}

// A grid edge of the whole map.
struct EdgeKey {
  std::uint64_t block;
  std::uint32_t edge;

  bool operator==(const EdgeKey&) const = default;
};
struct EdgeHash {
  std::size_t operator()(const EdgeKey& k) const { return mixed(k.block * 31 + k.edge); }
};

// The same key from whichever chunk the edge is seen: it belongs to the block that holds its lower corner.
EdgeKey edge_key(BlockIndex block, const ChunkVertex& v) {
  block.x += v.corner_x >> 4;
  block.y += v.corner_y >> 4;
  block.z += v.corner_z >> 4;
  const auto voxel = static_cast<std::uint32_t>(voxel_offset(v.corner_x & 15, v.corner_y & 15, v.corner_z & 15));
  return {pack(block), voxel * 3 + v.axis};
}

// Remembers the last answer: neighbours mostly bear the same id.
class ClassOfId {
 public:
  explicit ClassOfId(const PanopticMap& map) : map_(map) {}

  ClassId operator()(PanopticId id) {
    if (id != last_) class_ = map_.class_of(id);
    last_ = id;
    return class_;
  }

 private:
  const PanopticMap& map_;
  PanopticId last_ = PanopticId::kUnknown;
  ClassId class_ = ClassId::kUnknown;
};

}  // namespace

Fields fields(MesherOptions& o) {
  return {
      {"min_weight", &o.min_weight, "voxels observed with less weight than this are left out of the mesh", in_range(0, 1000)}};
}

std::size_t Mesher::update(const PanopticMap& panoptic_map) {
  const VoxelMap& map = panoptic_map.voxels;
  std::vector<Slot> slots;
  for (const Slot slot : map.changed_since(seen_epoch_)) add_with_lower_neighbours(map, map.index_of(slot), slots);
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  if (chunks_.size() < map.block_count()) chunks_.resize(map.block_count(), std::make_shared<const MeshChunk>());
  parallel_for(slots.size(), [&](std::size_t i) {
    std::shared_ptr<const MeshChunk>& chunk = chunks_[slots[i]];
    MeshChunk made = extract_chunk(map, panoptic_map.objects, slots[i], options_.min_weight);
    if (!made.triangles.empty() || !chunk->triangles.empty()) chunk = std::make_shared<const MeshChunk>(std::move(made));
  });
  seen_epoch_ = map.epoch();
  return slots.size();
}

Mesh Mesher::assemble(const PanopticMap& map) const {
  Mesh mesh;
  std::size_t vertex_count = 0;
  std::size_t triangle_count = 0;
  for (const auto& chunk : chunks_) {
    vertex_count += chunk->vertices.size();
    triangle_count += chunk->triangles.size();
  }
  mesh.vertices.reserve(vertex_count);
  mesh.triangles.reserve(triangle_count);
  std::unordered_map<EdgeKey, std::uint32_t, EdgeHash> border_vertices;
  std::vector<std::uint32_t> global;
  ClassOfId class_of(map);
  for (Slot slot = 0; slot < chunks_.size(); ++slot) {
    const MeshChunk& chunk = *chunks_[slot];
    global.resize(chunk.vertices.size());
    for (std::size_t i = 0; i < chunk.vertices.size(); ++i) {
      const ChunkVertex& v = chunk.vertices[i];
      auto next = static_cast<std::uint32_t>(mesh.vertices.size());
      if (on_border(v)) next = border_vertices.try_emplace(edge_key(map.voxels.index_of(slot), v), next).first->second;
      global[i] = next;
      if (next < mesh.vertices.size()) {
        mesh.vertices[next].normal += v.area_normal;
      } else {
        mesh.vertices.push_back({v.position, v.area_normal, v.color, class_of(v.panoptic_id), v.panoptic_id});
      }
    }
    for (const auto& t : chunk.triangles) mesh.triangles.push_back({global[t[0]], global[t[1]], global[t[2]]});
  }
  for (MeshVertex& v : mesh.vertices) {
    const float length = v.normal.norm();
    v.normal = length > 0 ? Vec3f(v.normal / length) : Vec3f::UnitZ();
  }
  return mesh;
}

}  // namespace panoptic
