// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the things that a rendering shows, and how well it shows them.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "panoptic/sim/renderer.h"

namespace panoptic {

struct VisibleThing {
  std::uint16_t instance = 0;
  ClassId class_id = ClassId::kUnknown;
  int area_px = 0;
  int x0 = 0;  // the box of its pixels, ends included
  int y0 = 0;
  int x1 = 0;
  int y1 = 0;
  int border_px = 0;               // of its pixels lie on the image's border
  Vec3d center_m = Vec3d::Zero();  // mean of its visible points in the camera's frame
};

// The visible things, ascending by instance.
std::vector<VisibleThing> visible_things(const Rendering& rendering, const Camera& camera);

// Pairs of positions in `things` (first below second): of one class, next to each other in the image and in depth.
std::vector<std::pair<std::size_t, std::size_t>> touching_pairs(const Rendering& rendering,
                                                                const std::vector<VisibleThing>& things);

}  // namespace panoptic
