// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The z-up frame of a map from its surface (UpFrame of planning.h).
#pragma once

#include <optional>

#include "panoptic/planning.h"
#include "panoptic/planning/surface_samples.h"

namespace panoptic {

// Level surface faces up within this angle's cosine: 20 degrees, steeper than any ramp that people walk.
inline constexpr float kLevelCosine = 0.94F;

// up_frame of planning.h for a surface that the caller has already. REQUIRES the surface of this map.
UpFrame up_frame(const PanopticMap& map, const SurfaceByBlock& surface, const std::optional<Vec3d>& up);

}  // namespace panoptic
