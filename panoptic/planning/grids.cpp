// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/grids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "panoptic/parallel.h"
#include "panoptic/planning/space_at.h"

namespace panoptic {
namespace {

constexpr float kBelowCeiling_m = 2.2F;  // higher surface is what hangs from the ceiling, or the ceiling

// True if the space at every height of the band was seen to be free.
bool is_all_free(const PanopticMap& map, const Pose& world_from_grid, const Eigen::Vector2d& at, const HeightBand& band,
                 double step_m) {
  const int steps = std::max(1, static_cast<int>(std::ceil((band.high_m - band.low_m) / step_m)));
  for (int i = 0; i < steps; ++i) {
    const double z = band.low_m + (i + 0.5) * (band.high_m - band.low_m) / steps;
    if (space_at(map, world_from_grid * Vec3d(at.x(), at.y(), z)) != Space::kFree) return false;
  }
  return true;
}

Eigen::Vector2i spot_of(const GroundGrid& grid, const GroundSample& sample) {
  return grid.around(sample.at_m.head<2>().cast<double>());
}

}  // namespace

GroundGrid ground_grid(const std::vector<GroundSample>& samples, double cell_m) {
  GroundGrid grid{cell_m};
  if (samples.empty()) return grid;
  Eigen::Vector2i low = Eigen::Vector2i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector2i high = Eigen::Vector2i::Constant(std::numeric_limits<int>::min());
  for (const GroundSample& sample : samples) {
    const Eigen::Vector2i spot = spot_of(grid, sample);
    low = low.cwiseMin(spot);
    high = high.cwiseMax(spot);
  }
  constexpr int kRim = 2;
  grid.low = low - Eigen::Vector2i::Constant(kRim);
  grid.size = high - low + Eigen::Vector2i::Constant(1 + 2 * kRim);
  return grid;
}

OccupancyGrid band_grid(const PanopticMap& map, const UpFrame& frame, const std::vector<GroundSample>& samples,
                        const GroundGrid& grid, const BandQuestion& question) {
  const HeightBand& band = question.band;
  OccupancyGrid occupancy{grid, std::vector<std::uint8_t>(grid.count(), kUnknownByte)};
  if (question.above_floor) {
    for (const GroundSample& sample : samples) {
      if (sample.is_floor && sample.at_m.z() <= band.low_m) occupancy.value[grid.index(spot_of(grid, sample))] = kFreeByte;
    }
  }
  for (const GroundSample& sample : samples) {
    const bool is_in = sample.at_m.z() >= band.low_m && sample.at_m.z() < band.high_m;
    if (is_in) occupancy.value[grid.index(spot_of(grid, sample))] = kOccupiedByte;
  }
  const Pose world_from_grid = frame.grid_from_world.inverse();
  parallel_for(static_cast<std::size_t>(grid.size.y()), [&](std::size_t row) {
    const auto width = static_cast<std::size_t>(grid.size.x());
    for (std::size_t i = row * width; i < (row + 1) * width; ++i) {
      if (occupancy.value[i] != kUnknownByte) continue;
      if (is_all_free(map, world_from_grid, grid.center_m(grid.at(i)), band, grid.cell_m)) occupancy.value[i] = kFreeByte;
    }
  });
  return occupancy;
}

SemanticGrid semantic_grid(const PanopticMap& map, const std::vector<GroundSample>& samples, const GroundGrid& grid) {
  SemanticGrid semantic{grid, std::vector<ClassId>(grid.count(), ClassId::kUnknown), std::vector<std::uint8_t>(grid.count(), 0)};
  std::vector<float> height(grid.count(), -std::numeric_limits<float>::infinity());
  for (const GroundSample& sample : samples) {
    const ClassId id = map.class_of(sample.label);
    if (sample.faces_down || sample.at_m.z() > kBelowCeiling_m || map.labels.name_of(id) == "ceiling") continue;
    const std::size_t i = grid.index(spot_of(grid, sample));
    semantic.is_seen[i] = 1;
    if (sample.at_m.z() <= height[i]) continue;
    height[i] = sample.at_m.z();
    semantic.class_at[i] = id;
  }
  return semantic;
}

std::string pgm_bytes(const OccupancyGrid& occupancy) {
  const GroundGrid& grid = occupancy.grid;
  std::string bytes = fmt::format("P5\n{} {}\n255\n", grid.size.x(), grid.size.y());
  const auto width = static_cast<std::size_t>(grid.size.x());
  for (int row = grid.size.y() - 1; row >= 0; --row) {
    bytes.append(reinterpret_cast<const char*>(occupancy.value.data()) + static_cast<std::size_t>(row) * width, width);
  }
  return bytes;
}

std::string map_server_yaml(const GroundGrid& grid, const std::string& image_name) {
  return fmt::format(
      "image: {}\nresolution: {:.6g}\norigin: [{:.6g}, {:.6g}, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
      image_name, grid.cell_m, grid.low.x() * grid.cell_m, grid.low.y() * grid.cell_m);
}

}  // namespace panoptic
