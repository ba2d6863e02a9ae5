// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The instances that an instance network would find in a frame.
#pragma once

#include <vector>

#include "panoptic/segmentation.h"
#include "panoptic/sim/displacement_field.h"
#include "panoptic/sim/observation.h"

namespace panoptic {

// The things that are found, in no order of meaning. Some things are missed, some are found two as one or one as two, and some
// are not there; boundaries stray, classes may be wrong, and scores are made for that.
std::vector<Instance> noisy_things(const Observation& observation, const DisplacementField& field);

}  // namespace panoptic
