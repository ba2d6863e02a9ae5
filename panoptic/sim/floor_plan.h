// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The rooms of an apartment, its walls, and the openings in them. A rectangle is cut again and again; the cuts are the inner
// walls.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/sim/home.h"

namespace panoptic {

constexpr double kInnerWall_m = 0.12;
constexpr double kOuterWall_m = 0.15;

enum class Side : std::uint8_t { kWest, kEast, kSouth, kNorth };  // of a room: -x, +x, -y, +y

// The inner face of a wall, seen from within its room: `along` points to the right, `inward` into the room.
struct WallFace {
  Eigen::Vector2d start;  // the left end
  Eigen::Vector2d along;
  Eigen::Vector2d inward;
  double length_m = 0;

  Eigen::Vector2d at(double along_m, double inward_m = 0) const { return start + along * along_m + inward * inward_m; }
};
WallFace wall_face(const Eigen::AlignedBox2d& floor, Side side);

enum class Hole : std::uint8_t { kDoorway, kEntrance, kWindow };

// An opening in a wall, as one of its rooms sees it; a doorway is listed once for each of its two rooms.
struct WallHole {
  Hole kind = Hole::kWindow;
  std::uint32_t room = 0;
  Side side = Side::kWest;
  double center_m = 0;  // along the wall's face
  double width_m = 0;
  double bottom_m = 0;
  double top_m = 0;
  std::uint32_t doorway = 0;  // index into doorways, for kDoorway

  double low_m() const { return center_m - width_m / 2; }
  double high_m() const { return center_m + width_m / 2; }
};

struct FloorPlan {
  Eigen::AlignedBox2d inside;  // between the inner faces of the outer walls
  std::vector<Room> rooms;
  std::vector<Doorway> doorways;
  std::vector<WallHole> holes;

  bool is_outer(std::uint32_t room, Side side) const;
};

// Rooms of 8 to 40 m2, every one reached from every other through doorways, and one entrance. Throws Error if the number of rooms
// is not 1..8.
FloorPlan make_floor_plan(const HomeOptions& options);

}  // namespace panoptic
