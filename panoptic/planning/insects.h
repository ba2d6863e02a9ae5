// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Insects that crawl on the walls of a map for a while, as those of `panoptic play` do. Metres, in the z-up frame.
#pragma once

#include <cstddef>
#include <vector>

#include "panoptic/planning.h"
#include "panoptic/planning/surface_samples.h"
#include "panoptic/planning/wall_meshes.h"

namespace panoptic {

inline constexpr double kAgentSample_s = 0.1;

struct InsectSample {
  double time_s = 0;
  std::size_t wall = 0;            // its place among the walls
  Vec3d position = Vec3d::Zero();  // on the surface
};

struct InsectTrack {
  std::vector<InsectSample> samples;  // every kAgentSample_s, from the beginning
  double crawled_m = 0;
  double farthest_m = 0;  // from the nearest sample of the surface, at most; 0.1 where none is near
};

// One for each of options.insects; none at all if no wall has a navigation mesh. `surface` and `frame` are those that the walls
// were made of. The same walls and options give the same steps.
std::vector<InsectTrack> let_crawl(const std::vector<WallMesh>& walls, const SurfaceByBlock& surface, const UpFrame& frame,
                                   const AgentOptions& options);

}  // namespace panoptic
