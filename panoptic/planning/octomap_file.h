// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The one seam to OctoMap.
#pragma once

#include <string>

#include "panoptic/distance_field.h"

namespace panoptic {

// The bytes of a .bt file: a leaf for each known cell of the field, occupied at and behind surfaces, else free. Throws Error if
// the map is wider than 65536 cells.
std::string octomap_bytes(const DistanceField::Values& values, double cell_m);

}  // namespace panoptic
