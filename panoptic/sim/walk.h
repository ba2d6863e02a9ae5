// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The way of a person who is to see everything in a home: a smooth line over the floor through all rooms and back.
#pragma once

#include <vector>

#include "panoptic/sim/clearance_map.h"
#include "panoptic/sim/home.h"

namespace panoptic {

// Something worth a look: a spot on a thing, a wall or the floor.
struct Sight {
  Vec3d point = Vec3d::Zero();
  Vec3d normal = Vec3d::UnitZ();
  std::uint32_t room = 0;
  double weight = 1;
};

// All sights of a home: the sides and tops of things, walls and floors in patches.
std::vector<Sight> sights(const Home& home, const ClearanceMap& clearance);

// True if the sight is seen well from an eye in its room: 0.75 to 3 m away and not too obliquely.
bool is_in_reach(const Sight& sight, const Vec3d& eye);

// Distances from walls and from all furniture below `head_m`.
ClearanceMap walking_clearance(const Home& home, double head_m);

struct Walk {
  std::vector<Eigen::Vector2d> points;   // kStep_m apart
  std::vector<std::size_t> look_around;  // indices of points where it pays to stop and look around, ascending
};
constexpr double kStep_m = 0.04;
constexpr double kBody_m = 0.29;  // the walk keeps this far from everything

Walk plan_walk(const Home& home, const ClearanceMap& clearance, const std::vector<Sight>& sights);

}  // namespace panoptic
