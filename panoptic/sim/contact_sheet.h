// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Homes at a glance.
#pragma once

#include "panoptic/image.h"
#include "panoptic/sim/simulation.h"

namespace panoptic {

// A row for each of `homes` homes with seeds first.seed, first.seed + 1 ...: colour as the camera gives it, depth (the nearer
// the brighter), classes, and instances, of the frame along the way that shows the most things.
Image<Rgb> contact_sheet(const SimulationOptions& first, int homes);

}  // namespace panoptic
