// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds objects that lie against each other, and how much of the smaller one does.
#pragma once

#include <span>
#include <vector>

#include "panoptic/objects/surface_voxels.h"

namespace panoptic {

struct Contact {
  LabelSlot smaller = LabelSlot::kUnknown;
  LabelSlot larger = LabelSlot::kUnknown;
  double share = 0;  // of the smaller one's surface voxels that are near the larger one
};

// All contacts of a share above `min_share` between the objects of `ids` (keys of `voxels`), the highest share first, then
// the lowest ids. Near: at most `reach` voxels apart. From kFarReach on that is measured in cells of reach / 15 voxels an edge,
// rounded up: the time does not grow with the reach, and each place is known to a cell. Pairs of which neither
// one is asked for, by label, are left out; an empty list asks for all.
inline constexpr int kFarReach = kBlockSide;
std::vector<Contact> contacts_between(std::span<const LabelSlot> ids, const VoxelsByLabel& voxels, const SurfaceVoxels& surface,
                                      int reach, double min_share = 0, const std::vector<bool>& asked = {});

}  // namespace panoptic
