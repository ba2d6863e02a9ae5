// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Things that networks find where there are none.
#pragma once

#include <vector>

#include "panoptic/segmentation.h"
#include "panoptic/sim/observation.h"

namespace panoptic {

// Pieces of whatever surface there is, at places of the world that stay the same: a piece that looks like a chair in one frame
// does so in the next.
std::vector<Instance> hallucinations(const Observation& observation);

}  // namespace panoptic
