// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The files of a plan (docs/planning.md), one function each. They throw Error if a file cannot be written.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/distance_field.h"
#include "panoptic/home_plan.h"
#include "panoptic/planning/agents.h"
#include "panoptic/planning/grids.h"
#include "panoptic/planning/ground.h"
#include "panoptic/planning/wall_meshes.h"

namespace panoptic {

using Folder = std::filesystem::path;

// Four rows of four numbers.
Json to_json(const Pose& pose);
Json to_json(const Vec3d& v);

// esdf.npy and esdf.json.
void write_esdf(const Folder& folder, const DistanceField& field, const DistanceField::Values& values);
// NAME.pgm and NAME.yaml.
void write_occupancy(const Folder& folder, const std::string& name, const OccupancyGrid& grid);
// "grid_0.1_1.5": the name of a band's grid.
std::string grid_name(const HeightBand& band);
// semantic.png and legend.json.
void write_semantic(const Folder& folder, const SemanticGrid& semantic, const LabelSet& labels, const UpFrame& frame);
// navmesh.bin, navmesh.glb and navmesh.json.
void write_navigation(const Folder& folder, const Ground& ground, const RecastMesh& mesh, const LabelSet& labels);
// The contents of walls.bin and walls.json, and the files.
std::string wall_bytes(const std::vector<WallMesh>& walls);
Json walls_json(const std::vector<WallMesh>& walls, const UpFrame& frame);
void write_walls(const Folder& folder, const std::vector<WallMesh>& walls, const UpFrame& frame);
// The contents of affordances.json (docs/home_plan.md).
Json affordances_json(const HomePlan& plan);
// The log of agents (agents.json).
void write_agents(const std::filesystem::path& file, const AgentsRun& run, const PlanOptions& options, const UpFrame& frame);
// path.json; path.png is the caller's.
void write_path(const Folder& folder, const Path& path, const Journey& journey, const UpFrame& frame);

}  // namespace panoptic
