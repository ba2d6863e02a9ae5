// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Openings in walls: gaps in the plane of a wall through which empty space or the floor runs on, and closed leaves of doors.
#pragma once

#include <vector>

#include "panoptic/home_plan.h"
#include "panoptic/planning/walls.h"

namespace panoptic {

struct WalledFloor {
  const std::vector<WallPlane>& planes;
  const OpenFloor& floor;
};

// Without the rooms, which rooms.h finds between the doors.
std::vector<Opening> find_doors(const LabelledSurface& surface, const LabelSet& labels, const WalledFloor& home);

// The part of the floor that an opening takes up, through the whole wall.
Polygon threshold_of(const Opening& opening, double beyond_m);

}  // namespace panoptic
