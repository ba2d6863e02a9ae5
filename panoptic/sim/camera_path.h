// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The way of a hand-held camera through a home.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/sim/home.h"

namespace panoptic {

struct PathOptions {
  std::uint64_t seed = 1;
  int frames = 0;  // 0 = as long as a person takes at 30 Hz; else the same way in so many frames
  int laps = 1;    // the way leads back to where it began, and may be walked again
};

// Poses world_from_camera, one per frame: through every room and back (loops), 1.2 to 1.7 m above the floor, looking at
// furniture and walls, smooth, at least 0.25 m from walls and furniture of that height. Deterministic.
std::vector<Pose> make_camera_path(const Home& home, const PathOptions& options);

}  // namespace panoptic
