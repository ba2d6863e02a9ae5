// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map: voxels, the space that was seen to be empty, the objects that labels name, what became of
// others, and the classes of all.
#pragma once

#include <vector>

#include "panoptic/free_space.h"
#include "panoptic/labels.h"
#include "panoptic/object_history.h"
#include "panoptic/objects.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// Not thread-safe, like its parts.
struct PanopticMap {
  LabelSet labels;
  VoxelMap voxels;
  FreeSpaceMap free_space;
  ObjectRegistry objects;
  ObjectHistory history;

  // An empty map. Throws Error as VoxelMap does.
  PanopticMap(const MapOptions& options, LabelSet label_set);
  // REQUIRES objects that count from the first thing of the label set.
  PanopticMap(LabelSet label_set, VoxelMap voxel_map, ObjectRegistry registry);

  // The class of voxels with this label; for the slot of an object, its most probable class.
  ClassId class_of(LabelSlot slot) const;
  ClassId class_of(PanopticId id) const;  // kUnknown for an object that is no more

  // Forgets objects that no voxel holds, and frees slots that nothing names any more. `elsewhere`, by slot: named by something
  // other than voxels (ObjectRegistry::retire_unused).
  void prune(const std::vector<bool>& elsewhere = {});
};

}  // namespace panoptic
