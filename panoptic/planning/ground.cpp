// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/ground.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

using Spot = Eigen::Vector2i;

constexpr double kFarthestBelow_m = 2;    // from a point of the agent's body, or a camera in its hand, down to its feet
constexpr double kFarthestAbove_m = 0.3;  // from a point that was meant to be on the floor
constexpr double kReach_m = 1.5;          // from beside a thing to the thing: across a bed

// The highest walkable span of a spot that may be under the feet of whoever is at this height; nullptr if there is none.
const SolidSpan* under_feet(const SolidColumns& columns, const Spot& spot, double z_m) {
  const SolidSpan* best = nullptr;
  if (!columns.grid.contains(spot)) return best;
  for (const SolidSpan& span : columns.of(columns.grid.index(spot))) {
    if (span.is_walkable && span.top_m <= z_m + kFarthestAbove_m && span.top_m >= z_m - kFarthestBelow_m) best = &span;
  }
  return best;
}

Foothold foothold_on(const GroundGrid& grid, const Spot& spot, const SolidSpan& span) {
  const Eigen::Vector2d middle = grid.center_m(spot);
  return {{middle.x(), middle.y(), double{span.top_m}}, span.island};
}

std::string text_of(const Vec3d& p) { return fmt::format("{:.2f},{:.2f},{:.2f}", p.x(), p.y(), p.z()); }

// Says why nobody can stand at a point, which users named in the world.
[[noreturn]] void refuse_place(const Ground& ground, const char* name, const Vec3d& at_m) {
  const std::string place = fmt::format("the {} {}", name, text_of(ground.frame.grid_from_world.inverse() * at_m));
  const GroundGrid& grid = ground.columns.grid;
  const Spot spot = grid.around(at_m.head<2>());
  if (!grid.contains(spot)) throw Error(place + " lies outside of the map");
  for (const SolidSpan& span : ground.columns.of(grid.index(spot))) {
    const double above_m = double{span.top_m} - at_m.z();
    if (above_m > -kFarthestBelow_m && above_m < ground.agent.height_m + kFarthestAbove_m) {
      throw Error(place + " lies in an obstacle or too near to one for this radius, height and climb; name a place on the floor");
    }
  }
  throw Error(place + " lies where no floor was seen");
}

Foothold required_foothold(const Ground& ground, const char* name, const Vec3d& at_m) {
  if (!at_m.allFinite() || at_m.cwiseAbs().maxCoeff() > 1e5)
    throw Error(fmt::format("the {} is no place: its numbers are not finite or too large", name));
  const std::optional<Foothold> found = foothold(ground, at_m);
  if (!found) refuse_place(ground, name, at_m);
  return *found;
}

Path path_over(const RecastMesh& mesh, const Foothold& from, const Foothold& to) {
  if (from.island != to.island) {
    return {.why_not = "no way: between start and goal the floor ends, or a passage is too narrow or too low for the agent"};
  }
  const auto way = mesh.way(from.at_m, to.at_m);
  if (!way) return {.why_not = "no way: start or goal lies on a spot too small for the navigation mesh"};
  Path path{.found = true, .points_m = *way};
  for (std::size_t i = 1; i < way->size(); ++i) path.length_m += ((*way)[i] - (*way)[i - 1]).norm();
  return path;
}

// The spots that a thing covers, and its middle height.
struct Footprint {
  std::vector<Spot> spots;  // ascending, each once
  double middle_z_m = 0;
};

bool is_before(const Spot& a, const Spot& b) { return std::pair(a.y(), a.x()) < std::pair(b.y(), b.x()); }

Footprint footprint_of(const Ground& ground, PanopticId object) {
  Footprint print;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const GroundSample& sample : ground.samples) {
    if (ground.ids.at(sample.label) != object) continue;
    print.spots.push_back(ground.columns.grid.around(sample.at_m.head<2>().cast<double>()));
    low = std::min(low, double{sample.at_m.z()});
    high = std::max(high, double{sample.at_m.z()});
  }
  std::sort(print.spots.begin(), print.spots.end(), is_before);
  print.spots.erase(std::unique(print.spots.begin(), print.spots.end()), print.spots.end());
  print.middle_z_m = (low + high) / 2;
  return print;
}

// True if nothing solid but the thing itself is on the line between two spots at this height.
bool sees(const SolidColumns& columns, const Footprint& print, const Spot& from, const Spot& to) {
  const int steps = 2 * std::max(std::abs(to.x() - from.x()), std::abs(to.y() - from.y()));
  const Eigen::Vector2d step = (to - from).cast<double>() / std::max(steps, 1);
  for (int i = 0; i <= steps; ++i) {
    const Spot spot = (from.cast<double>() + step * i + Eigen::Vector2d::Constant(0.5)).array().floor().matrix().cast<int>();
    if (!columns.grid.contains(spot) || std::binary_search(print.spots.begin(), print.spots.end(), spot, is_before)) continue;
    for (const SolidSpan& span : columns.of(columns.grid.index(spot))) {
      if (span.low_m < print.middle_z_m && span.top_m > print.middle_z_m) return false;
    }
  }
  return true;
}

struct Candidate {
  double squared = 0;  // spots
  Spot spot;
  Spot nearest;  // of the thing
  const SolidSpan* span = nullptr;
};

// The walkable spots of the island around a thing, the nearest to it first.
std::vector<Candidate> candidates(const SolidColumns& columns, const Footprint& print, std::int32_t island) {
  const int reach = static_cast<int>(std::floor(kReach_m / columns.grid.cell_m));
  std::vector<double> squared(columns.grid.count(), std::numeric_limits<double>::infinity());
  std::vector<Spot> nearest(columns.grid.count(), Spot::Zero());
  std::vector<std::size_t> met;
  for (const Spot& spot : print.spots) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const Spot at = spot + Spot(dx, dy);
        const double here = dx * dx + dy * dy;
        if (here > reach * reach || !columns.grid.contains(at) || here >= squared[columns.grid.index(at)]) continue;
        if (std::isinf(squared[columns.grid.index(at)])) met.push_back(columns.grid.index(at));
        squared[columns.grid.index(at)] = here;
        nearest[columns.grid.index(at)] = spot;
      }
    }
  }
  std::vector<Candidate> found;
  for (const std::size_t column : met) {
    for (const SolidSpan& span : columns.of(column)) {
      if (span.island == island) found.push_back({squared[column], columns.grid.at(column), nearest[column], &span});
    }
  }
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return a.squared < b.squared || (a.squared == b.squared && is_before(a.spot, b.spot));
  });
  return found;
}

// The rim of a footprint: inner spots are never nearest to a place outside.
void keep_rim(std::vector<Spot>& spots) {
  const std::vector<Spot> all = spots;
  const auto has = [&](const Spot& spot) { return std::binary_search(all.begin(), all.end(), spot, is_before); };
  std::erase_if(spots, [&](const Spot& s) {
    return has(s + Spot(1, 0)) && has(s - Spot(1, 0)) && has(s + Spot(0, 1)) && has(s - Spot(0, 1));
  });
}

}  // namespace

double plan_cell_m(const VoxelMap& map) {
  constexpr double kCell_m = 0.048;
  const double voxel_m = std::round(map.voxel_size_m() * 1e6) / 1e6;  // 0.024, not the float nearest to it
  return voxel_m * std::max(1.0, std::round(kCell_m / voxel_m));
}

Ground ground_of(const PanopticMap& map, const UpFrame& frame, const SurfaceByBlock& surface, const AgentSize& agent) {
  Ground ground{frame, agent, ground_samples(map, frame, surface, agent.climb_m), {}, {}};
  ground.columns = solid_columns(ground.samples, plan_cell_m(map.voxels) / 2, map.voxels.voxel_size_m(), agent.climb_m);
  mark_walkable(ground.columns, agent);
  std::vector<bool> met(kLabelSlots, false);
  for (const GroundSample& sample : ground.samples) {
    if (met[number(sample.label)]) continue;
    met[number(sample.label)] = true;
    ground.ids[sample.label] = map.objects.id_of(sample.label);
  }
  return ground;
}

std::optional<Foothold> foothold(const Ground& ground, const Vec3d& point_m) {
  const GroundGrid& grid = ground.columns.grid;
  const Spot middle = grid.around(point_m.head<2>());
  const double radius = ground.agent.radius_m / grid.cell_m;
  const int reach = static_cast<int>(std::ceil(radius));
  std::optional<Foothold> best;
  double nearest = std::numeric_limits<double>::infinity();
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const double squared = dx * dx + dy * dy;
      if (squared > radius * radius || squared >= nearest) continue;
      const SolidSpan* span = under_feet(ground.columns, middle + Spot(dx, dy), point_m.z());
      if (span == nullptr) continue;
      nearest = squared;
      best = foothold_on(grid, middle + Spot(dx, dy), *span);
    }
  }
  if (best && nearest == 0) best->at_m.head<2>() = point_m.head<2>();
  return best;
}

std::optional<Foothold> foothold_beside(const Ground& ground, PanopticId object, std::int32_t island) {
  const Footprint print = footprint_of(ground, object);
  if (print.spots.empty()) throw Error(fmt::format("object {} has no surface in the map", number(object)));
  Footprint rim = print;
  keep_rim(rim.spots);
  for (const Candidate& c : candidates(ground.columns, rim, island)) {
    if (sees(ground.columns, print, c.spot, c.nearest)) return foothold_on(ground.columns.grid, c.spot, *c.span);
  }
  return std::nullopt;
}

Path path_between(const Ground& ground, const RecastMesh& mesh, const Vec3d& from_m, const Vec3d& to_m) {
  const Foothold from = required_foothold(ground, "start", from_m);
  const Foothold to = required_foothold(ground, "goal", to_m);
  return path_over(mesh, from, to);
}

Path path_beside(const Ground& ground, const RecastMesh& mesh, const Vec3d& from_m, PanopticId goal) {
  const Foothold from = required_foothold(ground, "start", from_m);
  const std::optional<Foothold> to = foothold_beside(ground, goal, from.island);
  if (!to)
    return {.why_not = fmt::format("no way: no place within {:.1f} m of the object can be reached from the start", kReach_m)};
  return path_over(mesh, from, *to);
}

double walkable_area_m2(const SolidColumns& columns) {
  const auto spots =
      std::count_if(columns.spans.begin(), columns.spans.end(), [](const SolidSpan& span) { return span.is_walkable; });
  return static_cast<double>(spots) * columns.grid.cell_m * columns.grid.cell_m;
}

std::size_t island_count(const SolidColumns& columns) {
  std::int32_t most = 0;
  for (const SolidSpan& span : columns.spans) most = std::max(most, span.island);
  return static_cast<std::size_t>(most);
}

}  // namespace panoptic
