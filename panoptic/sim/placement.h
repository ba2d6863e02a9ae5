// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Decides which furniture comes into which room, and where. Roles that the catalogue lacks, and pieces that find no place, are
// left out.
#pragma once

#include "panoptic/sim/room_layout.h"

namespace panoptic {

// Places everything that makes the room what its kind says. A living room also takes what the home has no room of its own for.
void furnish(RoomLayout& layout, const std::vector<Room>& home);

// The building blocks of the rules. All give the index of the placement.
struct AgainstWall {
  double gap_m = 0.02;
  double free_front_m = 0.6;       // kept free before it
  double free_sides_m = 0;         // likewise on its left and right
  bool in_corner = false;          // only there; otherwise wherever there is room
  std::optional<Side> side;        // only at that wall
  std::optional<double> center_m;  // only there along that wall
};
std::optional<std::size_t> against_wall(RoomLayout& layout, std::string_view role, const AgainstWall& rule = {});

// Places something to the left or right of `neighbour`, its back to the same wall.
std::optional<std::size_t> beside(RoomLayout& layout, std::string_view role, std::size_t neighbour, bool on_the_left,
                                  double gap_m = 0.03);

// Places something with its back to nothing, in the middle of the room.
std::optional<std::size_t> in_the_open(RoomLayout& layout, std::string_view role, double free_around_m);

// Places chairs on the sides of a table or desk, facing it, partly below it. `most` on all sides together.
int chairs_at(RoomLayout& layout, std::string_view role, std::size_t table, int most);
std::optional<std::size_t> chair_before(RoomLayout& layout, std::string_view role, std::size_t desk);

// Places things on the top of `carrier`; returns the number of them.
int things_on(RoomLayout& layout, std::string_view role, std::size_t carrier, int most);

// Families of rules, one file each.
void furnish_kitchen(RoomLayout& layout);                    // placement_kitchen.cpp
void furnish_bathroom(RoomLayout& layout);                   // placement_bathroom.cpp
void furnish_bedroom(RoomLayout& layout);                    // placement_private.cpp
void furnish_office(RoomLayout& layout);                     // placement_private.cpp
void furnish_living_room(RoomLayout& layout);                // placement_living.cpp
void furnish_dining(RoomLayout& layout);                     // placement_living.cpp
void hang_curtains(RoomLayout& layout, double probability);  // placement_walls.cpp
void hang_pictures(RoomLayout& layout, int most);            // placement_walls.cpp
void add_radiators(RoomLayout& layout);                      // placement_walls.cpp

}  // namespace panoptic
