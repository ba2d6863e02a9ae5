// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A furnished apartment: connected rooms with doors and windows, furniture by rules. The same options give the same home, byte
// for byte.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/sim/scene.h"

namespace panoptic {

class Catalogue;

enum class RoomKind : std::uint8_t { kLivingRoom, kKitchen, kBedroom, kBathroom, kOffice };

struct Room {
  RoomKind kind = RoomKind::kLivingRoom;
  Eigen::AlignedBox2d floor;  // between the inner faces of its walls
};

// An opening between two rooms that a person walks through.
struct Doorway {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  std::uint32_t room_a = 0;
  std::uint32_t room_b = 0;
  double width_m = 0.9;
};

struct HomeOptions {
  std::uint64_t seed = 1;
  int rooms = 4;  // 1..8
};

struct Home {
  Scene scene;
  std::vector<Room> rooms;
  std::vector<Doorway> doorways;
  double wall_height_m = 2.6;
};

// Throws Error if the options are out of range.
Home make_home(const HomeOptions& options, const Catalogue& catalogue);

}  // namespace panoptic
