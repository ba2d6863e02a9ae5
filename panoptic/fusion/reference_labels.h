// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The labels that the map already has at the pixels of a frame (Eq. 2).
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// Eq. 2: the label of the voxel at the back-projected depth point, per depth pixel (row-major). kUnknown where there is no
// depth, no voxel, or no label yet. Fills `labels`, keeping its memory. Rows run in parallel; the map is only read.
void reference_labels(const VoxelMap& map, const Frame& frame, const RegisteredFrame& registered, std::vector<LabelSlot>& labels);

}  // namespace panoptic
