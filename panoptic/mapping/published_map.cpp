// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/published_map.h"

#include <unordered_map>

namespace panoptic {
namespace {

class ClassOf {
 public:
  ClassOf(const std::vector<SnapshotObject>& objects, const LabelSet& labels) : labels_(labels) {
    for (const SnapshotObject& object : objects) classes_[object.id] = object.class_id;
  }
  ClassId operator()(PanopticId id) const {
    if (!labels_.is_object(id)) return static_cast<ClassId>(number(id));
    const auto found = classes_.find(id);
    return found == classes_.end() ? ClassId::kUnknown : found->second;
  }

 private:
  const LabelSet& labels_;
  std::unordered_map<PanopticId, ClassId> classes_;
};

void append(const MeshChunk& chunk, const ClassOf& class_of, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const ChunkVertex& v : chunk.vertices) {
    const Vec3f normal = v.area_normal.norm() > 0 ? Vec3f(v.area_normal.normalized()) : Vec3f(Vec3f::Zero());
    mesh.vertices.push_back({v.position, normal, v.color, class_of(v.panoptic_id), v.panoptic_id});
  }
  for (const auto& t : chunk.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

}  // namespace

PublishedMap published_map(const Snapshot& snapshot, const LabelSet& labels) {
  PublishedMap published{.revision = snapshot.revision,
                         .frame = snapshot.frame.index,
                         .objects = snapshot.objects,
                         .path_m = snapshot.path_m,
                         .finished = snapshot.run.finished};
  const ClassOf class_of(snapshot.objects, labels);
  for (const SnapshotChunk& chunk : snapshot.chunks) append(*chunk.surface, class_of, published.mesh);
  return published;
}

}  // namespace panoptic
