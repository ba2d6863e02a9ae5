// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map.h"

#include <utility>

#include "panoptic/error.h"

namespace panoptic {

PanopticMap::PanopticMap(const MapOptions& options, LabelSet label_set)
    : labels(std::move(label_set)), voxels(options), free_space(voxels.voxel_size_m()), objects(labels.first_thing()) {}

PanopticMap::PanopticMap(LabelSet label_set, VoxelMap voxel_map, ObjectRegistry registry)
    : labels(std::move(label_set)),
      voxels(std::move(voxel_map)),
      free_space(voxels.voxel_size_m()),
      objects(std::move(registry)) {
  PANOPTIC_ASSERT(objects.first_thing() == labels.first_thing());
}

ClassId PanopticMap::class_of(LabelSlot slot) const {
  return labels.is_object(slot) ? objects.class_of(slot) : static_cast<ClassId>(number(slot));
}

ClassId PanopticMap::class_of(PanopticId id) const {
  if (!labels.is_object(id)) return static_cast<ClassId>(number(id));
  const Object* object = objects.find(id);
  return object == nullptr ? ClassId::kUnknown : objects.class_of(object->slot);
}

void PanopticMap::prune(const std::vector<bool>& elsewhere) { objects.retire_unused(ids_in_use(voxels), elsewhere); }

}  // namespace panoptic
