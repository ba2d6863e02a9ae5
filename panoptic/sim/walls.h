// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The fabric of a home as triangles: walls with openings, floors, ceilings.
#pragma once

#include "panoptic/sim/floor_plan.h"
#include "panoptic/sim/scene.h"

namespace panoptic {

// Appends to the scene: for every room its wall faces, floor and ceiling; the reveals of openings; the outside of the outer
// walls; a lamp below every ceiling. Surfaces and their colours depend on the seed. uvs count textures (see surface_textures.h).
void add_fabric(const FloorPlan& plan, double wall_height_m, std::uint64_t seed, Scene& scene);

}  // namespace panoptic
