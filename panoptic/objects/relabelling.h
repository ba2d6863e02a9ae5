// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Changes of labels that object maintenance is made of.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/objects/surface_voxels.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// New labels for old ones, everywhere at once.
class Renaming {
 public:
  Renaming();

  void add(LabelSlot from, LabelSlot to) { new_label_[number(from)] = number(to); }
  LabelSlot of(LabelSlot label) const { return static_cast<LabelSlot>(new_label_[number(label)]); }

  // Renames in every voxel of the map, surface or not, in the frames' votes (FrameVotes::rename), and in the snapshot.
  void apply(VoxelMap& map, FrameVotes& votes, SurfaceVoxels& surface) const;

 private:
  std::vector<std::uint16_t> new_label_;
};

// Gives the holes the label most frequent among their neighbours, from the rim inwards; ties go to the lower label. More than
// three voxels from the rim they take only the label of surface in whose plane they lie: a wall goes on behind what was dropped,
// but a cabinet is no wall. Holes that nothing surrounds, and those that no rim explains, become unknown.
void fill_from_neighbours(std::vector<std::uint32_t> holes, const VoxelMap& map, SurfaceVoxels& surface);

}  // namespace panoptic
