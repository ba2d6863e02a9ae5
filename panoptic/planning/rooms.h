// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Rooms: the parts of the home that are left connected when its walls and doors are taken away.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "panoptic/home_plan.h"
#include "panoptic/planning/open_floor.h"

namespace panoptic {

// Adds the rooms to a plan that has its walls, doors and furniture, and tells the doors which rooms they join.
void add_rooms(const OpenFloor& floor, const LabelSet& labels, HomePlan& plan);

// "bathroom", "kitchen" ... by the things that no other room has; "room" where there are none of them.
std::string room_class(const std::vector<std::string_view>& things);

// The polygon with edges moved onto faces of walls that run along them within 20 cm, and corners where those meet.
Polygon on_walls(const Polygon& polygon, const std::vector<WallLine>& walls);

}  // namespace panoptic
