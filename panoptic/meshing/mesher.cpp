// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/meshing/mesher.h"

#include <algorithm>
#include <utility>

#include "panoptic/meshing/weld.h"
#include "panoptic/parallel.h"
#include "panoptic/surface.h"

namespace panoptic {
namespace {

// The blocks whose cells have corners in this one: itself and its neighbours towards lower coordinates.
void add_with_lower_neighbours(const VoxelMap& map, BlockIndex index, std::vector<Slot>& slots) {
  for (int n = 0; n < 8; ++n) {
    const Slot slot = map.find_slot({index.x - (n & 1), index.y - (n >> 1 & 1), index.z - (n >> 2 & 1)});
    if (slot != VoxelMap::kNoSlot) slots.push_back(slot);
  }
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

void set_classes(const PanopticMap& map, Mesh& mesh) {
  ClassOfId class_of(map);
  for (MeshVertex& v : mesh.vertices) v.class_id = class_of(v.panoptic_id);
}

// Blocks whose chunks are there at once.
constexpr std::size_t kBlocksAtOnce = 256;

// Room for the mesh of all blocks, if they are like those so far, and a tenth more. A mesh that has to move takes twice its
// memory meanwhile.
void expect_all(std::size_t blocks, std::size_t of_blocks, const std::vector<MeshChunk>& next, Welder& welder) {
  std::size_t vertices = welder.vertices();
  std::size_t triangles = welder.triangles();
  for (const MeshChunk& chunk : next) {
    vertices += chunk.vertices.size();
    triangles += chunk.triangles.size();
  }
  const double all = 1.1 * static_cast<double>(of_blocks) / static_cast<double>(blocks);
  const auto expected = [&](std::size_t count) { return static_cast<std::size_t>(all * static_cast<double>(count)); };
  if (!welder.has_room(vertices, triangles)) welder.expect(expected(vertices), expected(triangles));
}

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
  std::vector<PlacedChunk> placed;
  placed.reserve(chunks_.size());
  for (Slot slot = 0; slot < chunks_.size(); ++slot) placed.push_back({map.voxels.index_of(slot), chunks_[slot].get()});
  Mesh mesh = weld(placed);
  set_classes(map, mesh);
  return mesh;
}

// In the order of the slots, as Mesher::assemble does it.
Mesh surface_of(const PanopticMap& map, const MesherOptions& options) {
  Welder welder;
  const std::size_t blocks = map.voxels.block_count();
  for (std::size_t first = 0; first < blocks; first += kBlocksAtOnce) {
    std::vector<MeshChunk> chunks(std::min(kBlocksAtOnce, blocks - first));
    parallel_for(chunks.size(), [&](std::size_t i) {
      chunks[i] = extract_chunk(map.voxels, map.objects, static_cast<Slot>(first + i), options.min_weight);
    });
    expect_all(first + chunks.size(), blocks, chunks, welder);
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      welder.add({map.voxels.index_of(static_cast<Slot>(first + i)), &chunks[i]});
    }
  }
  Mesh mesh = welder.take();
  set_classes(map, mesh);
  return mesh;
}

}  // namespace panoptic
