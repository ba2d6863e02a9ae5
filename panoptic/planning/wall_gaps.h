// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Gaps in one face of a wall that a person can walk through.
#pragma once

#include <vector>

#include "panoptic/planning/walls.h"

namespace panoptic {

struct WallGap {
  Stretch width;
  double height_m = 0;      // of the wall above; 0 where none was seen
  bool has_lintel = false;  // wall above most of it
};

std::vector<WallGap> find_wall_gaps(const WallPlane& plane, const OpenFloor& floor);

}  // namespace panoptic
