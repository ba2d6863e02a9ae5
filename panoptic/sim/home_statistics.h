// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A home in numbers and as a plan.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/sim/home.h"

namespace panoptic {

struct HomeStatistics {
  double floor_m2 = 0;
  std::map<std::string, int> objects_of;  // things per class name
  int objects = 0;
  std::size_t triangles = 0;
};

HomeStatistics statistics(const Home& home);

// "61.2 m2 in 4 rooms, 58 objects, ...": one line, then one line per class.
std::string to_text(const HomeStatistics& statistics, const Home& home);

// Draws the home from above, 60 pixels per metre, north up: rooms, walls, doorways, things in the colours of their classes with
// a mark at their front, and the camera's path if there is one.
Image<Rgb> draw_plan(const Home& home, const std::vector<Pose>& path = {});

}  // namespace panoptic
