// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// What an instance network would find in a frame.
#pragma once

#include <vector>

#include "panoptic/data/segmentation.h"
#include "panoptic/sim/displacement_field.h"
#include "panoptic/sim/observation.h"

namespace panoptic {

// Things that are found: some not at all, some two as one or one as two, some that are not there; with boundaries that stray,
// classes that may be wrong, and scores made for that. In no order of meaning.
std::vector<Instance> noisy_things(const Observation& observation, const DisplacementField& field);

}  // namespace panoptic
