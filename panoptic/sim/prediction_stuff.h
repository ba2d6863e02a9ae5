// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The classes that a semantic network would give a frame's pixels.
#pragma once

#include "panoptic/image.h"
#include "panoptic/labels.h"
#include "panoptic/sim/displacement_field.h"
#include "panoptic/sim/observation.h"

namespace panoptic {

// The true classes with boundaries that stray, and with patches of wrong stuff: wall and floor lost or swapped, things and void
// taken for wall, or for floor where they are low. Patches stay with places of the world, more or less.
Image<ClassId> noisy_semantic(const Observation& observation, const DisplacementField& field);

}  // namespace panoptic
