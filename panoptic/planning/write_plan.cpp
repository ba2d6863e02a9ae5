// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <system_error>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/planning.h"
#include "panoptic/planning/agent_rules.h"
#include "panoptic/planning/home_plan.h"
#include "panoptic/planning/octomap_file.h"
#include "panoptic/planning/plan_files.h"
#include "panoptic/planning/plan_picture.h"
#include "panoptic/planning/space_at.h"
#include "panoptic/planning/up_frame.h"
#include "panoptic/profile.h"

namespace panoptic {
namespace {

void require_range(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw Error(fmt::format("{} of {} m: it takes {:g} to {:g} m", name, value, low, high));
}

void check_all(const PanopticMap& map, const PlanOptions& options) {
  check(options.agent);
  if (options.agents) check(*options.agents);
  std::map<std::string, int> names;
  for (const HeightBand& band : options.bands) {
    check(band);
    if (++names[grid_name(band)] > 1) throw Error(fmt::format("two bands would have one file, {}.pgm", grid_name(band)));
  }
  if (options.journey && !options.journey->to_object.empty()) node_named(map, options.journey->to_object);
}

// Lines about floors at other heights than the grid's own.
void note_other_floors(const std::vector<GroundSample>& samples, double voxel_m, std::vector<std::string>& notes) {
  constexpr double kBin_m = 0.25;
  constexpr double kSmallest_m2 = 1;
  constexpr float kOther_m = 0.5F;
  std::map<int, double> area_m2;
  for (const GroundSample& sample : samples) {
    if (!sample.is_floor || std::abs(sample.at_m.z()) < kOther_m) continue;
    area_m2[static_cast<int>(std::floor(sample.at_m.z() / kBin_m))] += voxel_m * voxel_m;
  }
  for (const auto& [bin, area] : area_m2) {
    if (area < kSmallest_m2) continue;
    notes.push_back(
        fmt::format("there is floor at another height, about {:.1f} m ({:.0f} m2): heights and grids count from the "
                    "largest floor, the navigation mesh holds them all",
                    (bin + 0.5) * kBin_m, area));
  }
}

// One after the other, each told to the watch.
class Planner {
 public:
  Planner(const Folder& folder, const PanopticMap& map, const PlanOptions& options, const PlanWatch& watch)
      : folder_(folder), map_(map), options_(options), watch_(watch) {}

  PlanSummary write() {
    check_all(map_, options_);
    next("surface");
    surface_ = surface_samples(map_.voxels);
    summary_.frame = up_frame(map_, surface_, options_.up);
    summary_.cell_m = plan_cell_m(map_.voxels);
    next("floor");
    make_ground();
    next("way");
    if (options_.journey) find_way();  // before anything is written: the start may be no place to stand
    if (options_.agents && !mesh_->has_polygons()) {
      throw Error("agents cannot live in this map: nowhere on its floor is there room for one of this size");
    }
    if (options_.agents && options_.agents->file.has_parent_path()) require_writable_folder(options_.agents->file.parent_path());
    require_writable_folder(folder_);
    remove_old_files();
    next("grids");
    write_grids();
    next("distances");
    write_distances();
    next("navigation mesh");
    write_navigation(folder_, ground_, *mesh_, map_.labels);
    next("walls");
    const std::vector<WallMesh> walls = wall_meshes(map_, summary_.frame, surface_);
    write_walls(folder_, walls, summary_.frame);
    summary_.walls = walls.size();
    next("rooms");
    const HomePlan home = plan_home(map_, surface_, summary_.frame.grid_from_world);
    write_home_plan(home, map_.labels, folder_);
    next("agents");
    if (options_.agents) let_agents_live(home, walls);
    return std::move(summary_);
  }

 private:
  void next(const char* step) {
    PANOPTIC_ASSERT(step_ < kPlanSteps);
    if (watch_) watch_(step, step_);
    ++step_;
  }

  void make_ground() {
    const Stopwatch stopwatch;
    ground_ = ground_of(map_, summary_.frame, surface_, options_.agent);
    mesh_.emplace(ground_.columns, options_.agent);
    summary_.mesh_ms = 1e3 * stopwatch.seconds();
    summary_.walkable_m2 = walkable_area_m2(ground_.columns);
    summary_.islands = island_count(ground_.columns);
    summary_.polygons = mesh_->polygon_count();
    if (const std::string note = note_of_space(map_); !note.empty()) summary_.notes.push_back(note);
    if (!summary_.frame.floor_is_labelled) {
      summary_.notes.emplace_back("no label says where the floor is: the lowest large level surface is taken for it");
    }
    note_other_floors(ground_.samples, map_.voxels.voxel_size_m(), summary_.notes);
    if (summary_.walkable_m2 <= 0) summary_.notes.emplace_back("nowhere on the floor is there room for an agent of this size");
  }

  void find_way() {
    const Pose& to_grid = summary_.frame.grid_from_world;
    const Journey& journey = *options_.journey;
    const Vec3d from = to_grid * journey.from_m;
    path_ = journey.to_m ? path_between(ground_, *mesh_, from, to_grid * *journey.to_m)
                         : path_beside(ground_, *mesh_, from, node_named(map_, journey.to_object));
    if (path_->found) {
      summary_.length_m = path_->length_m;
    } else {
      summary_.why_not = path_->why_not;
    }
  }

  // An earlier plan may have left files that this one does not write.
  void remove_old_files() const {
    std::error_code failed;
    for (const char* name : {"path.json", "path.png", "agents.json"}) {
      std::filesystem::remove(folder_ / name, failed);
      if (failed)
        throw Error(fmt::format("{}: an older file cannot be removed: {}", (folder_ / name).string(), failed.message()));
    }
  }

  void write_grids() {
    const GroundGrid grid = ground_grid(ground_.samples, summary_.cell_m);
    const HeightBand standing = {options_.agent.climb_m, options_.agent.height_m};
    const UpFrame& frame = summary_.frame;
    write_occupancy(folder_, "grid", band_grid(map_, frame, ground_.samples, grid, {standing, true}));
    for (const HeightBand& band : options_.bands) {
      write_occupancy(folder_, grid_name(band), band_grid(map_, frame, ground_.samples, grid, {band, false}));
    }
    const SemanticGrid semantic = semantic_grid(map_, ground_.samples, grid);
    write_semantic(folder_, semantic, map_.labels, frame);
    if (!path_) return;
    write_path(folder_, *path_, *options_.journey, frame);
    std::vector<Vec3d> ends = {frame.grid_from_world * options_.journey->from_m};
    if (options_.journey->to_m) ends.push_back(frame.grid_from_world * *options_.journey->to_m);
    if (path_->found) ends = {ends.front(), path_->points_m.back()};
    write_png(folder_ / "path.png", draw_path(semantic, map_.labels, ground_, *path_, ends));
  }

  void write_distances() {
    DistanceField field(summary_.frame, {.cell_m = summary_.cell_m});
    field.update(map_);
    const DistanceField::Values values = field.values();
    write_esdf(folder_, field, values);
    write_file(folder_ / "octomap.bt", octomap_bytes(values, summary_.cell_m));
  }

  void let_agents_live(const HomePlan& home, const std::vector<WallMesh>& walls) {
    AgentsRun run = let_live(*mesh_, home, options_.agent, *options_.agents);
    run.insects = let_crawl(walls, surface_, summary_.frame, *options_.agents);
    if (options_.agents->insects > 0 && run.insects.empty()) run.notes.emplace_back("the map has no wall for insects");
    summary_.agents = run.totals();
    summary_.notes.insert(summary_.notes.end(), run.notes.begin(), run.notes.end());
    const Folder& file = options_.agents->file;
    write_agents(file.empty() ? folder_ / "agents.json" : file, run, options_, summary_.frame);
  }

  const Folder& folder_;
  const PanopticMap& map_;
  const PlanOptions& options_;
  const PlanWatch& watch_;
  std::size_t step_ = 0;
  SurfaceByBlock surface_;
  Ground ground_;
  std::optional<RecastMesh> mesh_;
  std::optional<Path> path_;
  PlanSummary summary_;
};

}  // namespace

void check(const AgentSize& agent) {
  constexpr double kWidest_m = 5;
  constexpr double kTallest_m = 10;
  require_range("a radius", agent.radius_m, 0, kWidest_m);
  require_range("a height", agent.height_m, 0.02, kTallest_m);
  require_range("a climb", agent.climb_m, 0, 1);
  if (agent.climb_m < agent.height_m) return;
  throw Error(fmt::format("a climb of {} m is no less than the height of {} m", agent.climb_m, agent.height_m));
}

void check(const HeightBand& band) {
  constexpr double kFarthest_m = 1000;
  const bool fits = std::abs(band.low_m) <= kFarthest_m && std::abs(band.high_m) <= kFarthest_m && band.low_m < band.high_m;
  if (!fits) {
    throw Error(fmt::format("a band of heights from {} to {} m: it takes two heights within {:g} m, the lower one first",
                            band.low_m, band.high_m, kFarthest_m));
  }
}

void check(const AgentOptions& agents) {
  constexpr double kMostTogether_s = 36000;
  if (agents.count < 1 || agents.count > agent_rules::kMostAgents) {
    throw Error(fmt::format("{} agents: it takes 1 to {}", agents.count, agent_rules::kMostAgents));
  }
  if (agents.insects < 0 || agents.insects > agent_rules::kMostAgents) {
    throw Error(fmt::format("{} insects: it takes 0 to {}", agents.insects, agent_rules::kMostAgents));
  }
  const double most_s = kMostTogether_s / (agents.count + agents.insects);
  if (agents.seconds > 0 && agents.seconds <= most_s) return;
  throw Error(fmt::format("{} agents and {} insects for {} s: it takes more than 0, and at most {:g} s for so many", agents.count,
                          agents.insects, agents.seconds, std::floor(most_s)));
}

PlanSummary write_plan(const std::filesystem::path& folder, const PanopticMap& map, const PlanOptions& options,
                       const PlanWatch& watch) {
  return Planner(folder, map, options, watch).write();
}

}  // namespace panoptic
