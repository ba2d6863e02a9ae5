// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Level slices through the distances to the nearest surface, to look at.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/distance_field.h"

namespace panoptic {

inline constexpr int kSlicePixelsPerCell = 2;
inline constexpr double kSliceLine_m = 0.25;  // from one line of equal distance to the next

// A PNG of the cells whose z is `level`, north (+y) up: red at surfaces, blue at `cap_m` and beyond, grey behind surfaces, and
// see-through where nothing is known. REQUIRES a level of `values`.
std::vector<std::uint8_t> distance_slice_png(const DistanceField::Values& values, double cap_m, int level);

}  // namespace panoptic
