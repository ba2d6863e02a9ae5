// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Things from above.
#pragma once

#include <vector>

#include "panoptic/home_plan.h"
#include "panoptic/planning/labelled_surface.h"

namespace panoptic {

// One per object with more than a handful of surface, ascending by id: a box along its upright faces where they stand at right
// angles (one or two of the four may be hidden), else its hull. No more than a tenth of it was seen to be empty: pieces of the
// object that would make it more are left out, and a single piece that does, like a counter around a corner, keeps its outline.
std::vector<ThingFootprint> footprints(const LabelledSurface& surface, const SeenEmpty& seen_empty);

}  // namespace panoptic
