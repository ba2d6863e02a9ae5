// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map from above: where a band of heights is occupied, and which class is where.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/image.h"
#include "panoptic/planning/columns.h"

namespace panoptic {

// The bytes of a cell, as ROS's map_server takes them.
inline constexpr std::uint8_t kOccupiedByte = 0;
inline constexpr std::uint8_t kUnknownByte = 205;
inline constexpr std::uint8_t kFreeByte = 254;

struct OccupancyGrid {
  GroundGrid grid;
  std::vector<std::uint8_t> value;
};

// The cells under all samples.
GroundGrid ground_grid(const std::vector<GroundSample>& samples, double cell_m);

// A cell is occupied if there is surface between the two heights. It is free if all heights of the band were seen to be free
// or, for a band `above_floor`, if its floor was seen: whoever sees the floor looks through what is above it. Else it is unknown.
struct BandQuestion {
  HeightBand band;
  bool above_floor = false;
};
OccupancyGrid band_grid(const PanopticMap& map, const UpFrame& frame, const std::vector<GroundSample>& samples,
                        const GroundGrid& grid, const BandQuestion& question);

// The class of the highest surface below the ceiling in each cell; floor only where nothing stands. kUnknown also where there is
// no surface, which `is_seen` tells apart.
struct SemanticGrid {
  GroundGrid grid;
  std::vector<ClassId> class_at;
  std::vector<std::uint8_t> is_seen;
};
SemanticGrid semantic_grid(const PanopticMap& map, const std::vector<GroundSample>& samples, const GroundGrid& grid);

// The bytes of a .pgm file, the row with the highest y first, and of the .yaml file beside it.
std::string pgm_bytes(const OccupancyGrid& occupancy);
std::string map_server_yaml(const GroundGrid& grid, const std::string& image_name);

}  // namespace panoptic
