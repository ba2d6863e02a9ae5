// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The truth about a home for those who plan in it: where people sit and lie, table tops, doors, rooms. It follows from the models
// and from the floor plan alone, whether a camera saw them or not. MovingHome axes: z up, the floor at z = 0; metres.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "panoptic/base/polygon.h"
#include "panoptic/sim/home.h"

namespace panoptic {

// The place of one person; a sofa has several, at least 0.55 m wide each.
struct TrueSeat {
  Vec3d position = Vec3d::Zero();  // the middle of the place, on its surface
  Vec2d facing = Vec2d::UnitX();   // away from the back rest
  std::uint16_t instance = 0;
};

// A table top, or a surface that one person can lie on.
struct TrueLevel {
  Polygon polygon;
  double height_m = 0;
  std::uint16_t instance = 0;
};

struct TrueDoor {
  Vec2d center = Vec2d::Zero();  // in the middle of the wall
  Vec2d along = Vec2d::UnitX();  // the wall
  double width_m = 0;
  double height_m = 0;
  bool is_open = true;               // else a leaf closes it
  std::vector<std::uint32_t> rooms;  // one for the entrance
};

struct TrueRoom {
  RoomKind kind = RoomKind::kLivingRoom;
  Polygon polygon;
  std::vector<std::uint16_t> things;  // instances whose middle lies in it
};

struct PlanTruth {
  std::vector<TrueSeat> seats;
  std::vector<TrueLevel> lying_places;
  std::vector<TrueLevel> table_tops;
  std::vector<TrueDoor> doors;
  std::vector<TrueRoom> rooms;
};

// `options`: those of the home.
PlanTruth home_truth(const Home& home, const HomeOptions& options);

// Writes affordances_truth.json and rooms_truth.json, with the members of affordances.json and rooms.json (docs/home_plan.md);
// `object` is the thing's instance. Throws FileError.
void write_home_truth(const PlanTruth& truth, const std::filesystem::path& folder);

// "living room"
const char* name_of(RoomKind kind);

}  // namespace panoptic
