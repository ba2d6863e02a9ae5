// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Cheapest ways over the floor of a home.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/sim/clearance_map.h"

namespace panoptic {

// From one cell to all others that a body of a given half width reaches, and back along them.
struct WaysFrom {
  std::vector<float> cost;  // infinite where nobody comes
  std::vector<std::int32_t> previous;
};

// Keeps `body_m` from everything; nearer to things than is comfortable a way is dearer.
WaysFrom ways_from(const ClearanceMap& clearance, int start, double body_m);

// The way to a cell with a finite cost, rounded off without coming nearer to anything than body_m; points step_m apart, the
// last one nearer.
std::vector<Eigen::Vector2d> smooth_way(const ClearanceMap& clearance, const WaysFrom& ways, int to, double body_m,
                                        double step_m);

}  // namespace panoptic
