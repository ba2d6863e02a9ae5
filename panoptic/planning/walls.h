// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The faces of walls as vertical planes in any direction, found by their normals, and where along each there is wall.
#pragma once

#include <vector>

#include "panoptic/home_plan.h"
#include "panoptic/planning/open_floor.h"

namespace panoptic {

// Heights above the floor between which a wall stops a person: above skirting boards and thresholds, below the lintels of doors.
inline constexpr double kWallLow_m = 0.2;
inline constexpr double kWallHigh_m = 1.9;

struct Stretch {
  double low_m = 0;
  double high_m = 0;

  double length_m() const { return high_m - low_m; }
};

// Points p with normal.dot(p) = offset_m; the normal points into the room.
struct WallPlane {
  Vec2d normal = Vec2d::UnitX();
  double offset_m = 0;
  std::vector<LabelledPoint> points;  // of the face
  std::vector<Stretch> solid;         // where along it a wall was seen between those heights, ascending

  Vec2d tangent() const { return quarter_turn(normal); }
  Vec2d at(double along_m, double before_m = 0) const { return normal * (offset_m + before_m) + tangent() * along_m; }
  double along_m(const Vec2d& p) const { return tangent().dot(p); }
  double before_m(const Vec2d& p) const { return normal.dot(p) - offset_m; }
};

// Planes with at least 0.15 m2 of surface.
std::vector<WallPlane> find_wall_planes(const LabelledSurface& surface);

// The solid stretches of all planes as lines. Stretches between which nobody can pass are joined: something hides the wall there.
// Ends near another wall's face meet it.
std::vector<WallLine> wall_lines(const std::vector<WallPlane>& planes, const OpenFloor& floor);

}  // namespace panoptic
