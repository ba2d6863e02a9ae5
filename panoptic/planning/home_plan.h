// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The plan of a home (home_plan.h of the public headers) from a surface that the caller has already.
#pragma once

#include "panoptic/home_plan.h"
#include "panoptic/planning/surface_samples.h"

namespace panoptic {

// REQUIRES the surface of this map. Throws Error as plan_home does.
HomePlan plan_home(const PanopticMap& map, const SurfaceByBlock& samples, const Pose& grid_from_world);

}  // namespace panoptic
