// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/floor_grids.h"

#include <utility>

#include "panoptic/planning/grids.h"
#include "panoptic/planning/ground.h"

namespace panoptic {
namespace {

std::vector<Space> spaces(const OccupancyGrid& occupancy) {
  std::vector<Space> spaces;
  spaces.reserve(occupancy.value.size());
  for (const std::uint8_t byte : occupancy.value) {
    const Space other = byte == kFreeByte ? Space::kFree : Space::kUnknown;
    spaces.push_back(byte == kOccupiedByte ? Space::kOccupied : other);
  }
  return spaces;
}

}  // namespace

FloorGrids floor_grids(const PanopticMap& map, const UpFrame& frame, const AgentSize& agent,
                       const std::vector<HeightBand>& bands) {
  check(agent);
  for (const HeightBand& band : bands) check(band);
  const std::vector<GroundSample> samples = ground_samples(map, frame, surface_samples(map.voxels), agent.climb_m);
  const GroundGrid grid = ground_grid(samples, plan_cell_m(map.voxels));
  FloorGrids all{grid.cell_m, grid.low.cast<double>() * grid.cell_m, grid.size.x(), grid.size.y()};
  const HeightBand standing = {agent.climb_m, agent.height_m};
  all.standing = spaces(band_grid(map, frame, samples, grid, {standing, true}));
  for (const HeightBand& band : bands) all.bands.push_back(spaces(band_grid(map, frame, samples, grid, {band, false})));
  SemanticGrid semantic = semantic_grid(map, samples, grid);
  all.class_at = std::move(semantic.class_at);
  all.is_seen = std::move(semantic.is_seen);
  return all;
}

}  // namespace panoptic
