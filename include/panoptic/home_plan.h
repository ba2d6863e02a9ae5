// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A mapped home for those who live in it: seats, places to lie, table tops, doors, rooms and walls. Everything reads a const
// PanopticMap. Metres, in the z-up frame (UpFrame of planning.h); docs/planning.md has the rules with their reasons, and
// the files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/map.h"

namespace panoptic {

// The place of one person on a chair or a sofa.
struct Seat {
  Vec3d position = Vec3d::Zero();  // the middle of the place, on its surface
  Vec3d normal = Vec3d::UnitZ();
  Vec3d facing = Vec3d::UnitX();  // horizontal, unit length: where the person's knees point to
  double height_m = 0;            // above the floor
  bool has_back = false;          // else `facing` follows from what is around
  PanopticId object = PanopticId::kUnknown;
};

// A surface that a person can lie on.
struct LyingPlace {
  std::vector<Vec3d> polygon;  // counter-clockwise from above
  Vec3d center = Vec3d::Zero();
  Vec3d axis = Vec3d::UnitX();  // along its length, horizontal; towards a head board if there is one
  double length_m = 0;
  double width_m = 0;
  double height_m = 0;
  PanopticId object = PanopticId::kUnknown;
};

struct TableTop {
  std::vector<Vec3d> polygon;                       // counter-clockwise from above
  std::vector<std::vector<Vec3d>> free_rectangles;  // on which nothing stands, four corners each, largest first
  double height_m = 0;
  double area_m2 = 0;
  PanopticId object = PanopticId::kUnknown;
};

// A doorway, an opening as wide as one, or a door that is closed. Two sides of a wall are one opening.
struct Opening {
  Vec3d center = Vec3d::Zero();  // in the middle of the wall, on the floor
  Vec3d along = Vec3d::UnitX();  // the wall, horizontal
  double width_m = 0;
  double height_m = 0;  // of the wall above it; 2 where nobody saw that
  double wall_m = 0;    // thickness of the wall; 0 where one side alone was seen
  bool is_open = true;
  PanopticId leaf = PanopticId::kUnknown;  // the door's leaf, if it has one
  std::vector<Eigen::Vector2d> leaf_line;  // its two ends from above
  std::vector<int> rooms;                  // at most two ids of MappedRoom
};

struct MappedRoom {
  int id = 0;
  std::string class_name;                // "kitchen" ... "room" if its objects tell nothing
  std::vector<Eigen::Vector2d> polygon;  // counter-clockwise, along the walls' faces
  double area_m2 = 0;
  std::vector<PanopticId> objects;
  std::vector<int> doors;  // places in HomePlan::doors
};

// A stretch of a wall's face.
struct WallLine {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // into the room
};

// A thing from above.
struct ThingFootprint {
  PanopticId object = PanopticId::kUnknown;
  ClassId class_id = ClassId::kUnknown;
  std::vector<Eigen::Vector2d> polygon;
  double low_m = 0;  // above the floor
  double high_m = 0;
};

struct HomePlan {
  Pose grid_from_world = Pose::Identity();
  std::vector<Seat> seats;
  std::vector<LyingPlace> lying_places;
  std::vector<TableTop> table_tops;
  std::vector<Opening> doors;
  std::vector<MappedRoom> rooms;
  std::vector<WallLine> walls;
  std::vector<ThingFootprint> furniture;
};

// Throws Error if the map has no surface or the pose is not finite.
HomePlan plan_home(const PanopticMap& map, const Pose& grid_from_world);

// The plan as architects draw it: walls, doors and windows, furniture with names, rooms with names and areas, a scale.
std::string floor_plan_svg(const HomePlan& as_it_lies, const LabelSet& labels);

// Writes affordances.json, rooms.json and floorplan.svg. Throws FileError.
void write_home_plan(const HomePlan& plan, const LabelSet& labels, const std::filesystem::path& folder);

}  // namespace panoptic
