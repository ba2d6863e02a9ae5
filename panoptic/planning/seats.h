// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the places where people sit and lie.
#pragma once

#include <vector>

#include "panoptic/home_plan.h"
#include "panoptic/planning/labelled_surface.h"

namespace panoptic {

// The seats of chairs, stools and sofas, by object. A seat without a back rest faces the nearest of the table tops within a
// metre, else away from the nearest wall.
std::vector<Seat> find_seats(const LabelledSurface& surface, const LabelSet& labels, const std::vector<TableTop>& tables);

std::vector<LyingPlace> find_lying_places(const LabelledSurface& surface, const LabelSet& labels);

}  // namespace panoptic
