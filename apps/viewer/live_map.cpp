// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/live_map.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace panoptic {
namespace {

// The objects of the snapshot with slots in the order of their ids, each of the class that it has now.
ObjectRegistry registry_of(const Snapshot& snapshot, std::uint16_t first_thing) {
  RegistryState state;
  state.next_id = PanopticId{first_thing};
  for (const SnapshotObject& seen : snapshot.objects) {
    Object& object = state.objects.emplace_back();
    object.id = seen.id;
    object.slot = static_cast<LabelSlot>(first_thing + state.objects.size() - 1);
    object.evidence[seen.class_id] = object.score_sum = 1;
    state.next_id = PanopticId{number(seen.id) + 1};
  }
  return {first_thing, std::move(state)};
}

// The slot of an id; remembers the last answer, since neighbours mostly bear the same one.
class SlotOf {
 public:
  explicit SlotOf(const PanopticMap& map) : map_(map) {}

  LabelSlot operator()(PanopticId id) {
    if (id != last_) slot_ = found(id);
    last_ = id;
    return slot_;
  }

 private:
  LabelSlot found(PanopticId id) const {
    if (!map_.labels.is_object(id)) return static_cast<LabelSlot>(number(id));
    const Object* object = map_.objects.find(id);
    return object == nullptr ? LabelSlot::kUnknown : object->slot;
  }

  const PanopticMap& map_;
  PanopticId last_ = PanopticId::kUnknown;
  LabelSlot slot_ = LabelSlot::kUnknown;
};

// An edge on the border belongs to the next chunk, which has it, too.
bool is_own(const ChunkVertex& v) { return std::max({v.corner_x, v.corner_y, v.corner_z}) < kBlockSide; }

std::vector<SurfaceSample> samples_of(const MeshChunk& chunk, SlotOf& slot_of) {
  std::vector<SurfaceSample> samples;
  samples.reserve(chunk.vertices.size());
  for (const ChunkVertex& v : chunk.vertices) {
    if (!is_own(v)) continue;
    samples.push_back({v.position, v.area_normal.normalized(), slot_of(v.panoptic_id), v.weight});
  }
  return samples;
}

}  // namespace

LiveMap live_map(const Snapshot& snapshot, const SnapshotScene& scene) {
  const MapOptions options{.voxel_size_m = scene.voxel_size_m, .free_space = false};
  LiveMap live{{scene.labels, VoxelMap(options), registry_of(snapshot, scene.labels.first_thing())}, {}};
  SlotOf slot_of(live.map);
  for (const SnapshotChunk& chunk : snapshot.chunks) live.surface.push_back(samples_of(*chunk.surface, slot_of));
  return live;
}

}  // namespace panoptic
