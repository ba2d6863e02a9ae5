// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Maps for those who move: which way is up and where the floor is. Everything reads a const PanopticMap. Metres. The grid frame
// has z up and the floor near z = 0; docs/planning.md describes it and the files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/map.h"

namespace panoptic {

// Whoever moves: a cylinder that stands upright.
struct AgentSize {
  double radius_m = 0.2;
  double height_m = 1.5;
  double climb_m = 0.05;  // the highest step that it takes
};

// Heights above the floor, low_m <= z < high_m.
struct HeightBand {
  double low_m = 0;
  double high_m = 0;
};

// People who live in the map for a while and decide for themselves: they walk, sit and lie as those of `panoptic play` do. The
// same options and map give the same steps.
struct AgentOptions {
  int count = 0;        // 1 to 32
  int insects = 0;      // up to 32, who crawl on the walls beside them
  double seconds = 60;  // of their time; all of them together at most 36,000
  std::uint32_t seed = 1;
  std::filesystem::path file;  // empty: agents.json in the folder
};

// The z-up frame of a map. It is turned no more than it takes to make up +z, and moved along z alone.
struct UpFrame {
  Pose grid_from_world = Pose::Identity();
  bool floor_is_labelled = false;  // else the floor is the lowest large level surface
  double floor_area_m2 = 0;        // level surface near z = 0

  Vec3d up() const { return grid_from_world.linear().row(2).transpose(); }  // in the world
};

// The frame of this map. `up`: about upwards in the world, within 45 degrees; without it the normals of floor and ceiling tell.
// Throws Error if the map has no surface, if there is no level surface in it, or if nothing tells which way is up.
UpFrame up_frame(const PanopticMap& map, const std::optional<Vec3d>& up = {});

// Throws Error, naming what is out of range, if no agent has this size; likewise for bands, and for how many agents live how
// long.
void check(const AgentSize& agent);
void check(const HeightBand& band);
void check(const AgentOptions& agents);

// From where to where; in the world of the map, as `panoptic query` gives places.
struct Journey {
  Vec3d from_m = Vec3d::Zero();
  std::optional<Vec3d> to_m;
  std::string to_object;  // instead of to_m: a node of scene.glb
};

struct PlanOptions {
  AgentSize agent;
  std::vector<HeightBand> bands;   // heights for grids of their own
  std::optional<Journey> journey;  // for path.json
  std::optional<Vec3d> up;         // see up_frame
  std::optional<AgentOptions> agents;
};

// Sums over all agents.
struct AgentTotals {
  int agents = 0;
  double walked_m = 0;
  int seats = 0;       // reached, and sat on
  int beds = 0;        // likewise
  int gave_up = 0;     // ways that ended before their goal: others blocked them for too long, or stood where it is
  double stuck_s = 0;  // time in which somebody stood in their way
  int insects = 0;
  double crawled_m = 0;
  double farthest_m = 0;  // of an insect from the nearest sample of the map's surface, at most
};

// The contents of what was written.
struct PlanSummary {
  UpFrame frame;
  double cell_m = 0;               // of grids and distances
  double walkable_m2 = 0;          // where the agent's centre may be
  std::size_t islands = 0;         // parts of the floor without a way between them
  std::size_t polygons = 0;        // of the navigation mesh
  std::size_t walls = 0;           // with a navigation mesh of their own
  double mesh_ms = 0;              // to make the floor's navigation mesh
  std::optional<double> length_m;  // of the path, if there is one
  std::string why_not;             // if a path was asked for and there is none
  std::optional<AgentTotals> agents;
  std::vector<std::string> notes;  // a line each: what to know about these files
};

// Hears the name of each step before it begins, and its number from 0.
using PlanWatch = std::function<void(const std::string& step, std::size_t number)>;
inline constexpr std::size_t kPlanSteps = 9;

// Writes the files of docs/planning.md into the folder, which it makes. Throws Error: options out of range, a map without floor,
// a start or goal that is no place to stand, an object that is not there, a file that cannot be written.
PlanSummary write_plan(const std::filesystem::path& folder, const PanopticMap& map, const PlanOptions& options = {},
                       const PlanWatch& watch = {});

}  // namespace panoptic
