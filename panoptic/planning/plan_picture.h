// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A picture of the floor from above with a way over it.
#pragma once

#include "panoptic/image.h"
#include "panoptic/planning/grids.h"
#include "panoptic/planning/ground.h"

namespace panoptic {

// North (+y) is up. Where the agent may be is green, the way blue, the start a green disc, the goal a red one.
Image<Rgb> draw_path(const SemanticGrid& semantic, const LabelSet& labels, const Ground& ground, const Path& path,
                     const std::vector<Vec3d>& ends_m);

}  // namespace panoptic
