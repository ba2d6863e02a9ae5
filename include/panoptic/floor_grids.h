// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map from above, in cells: where an agent has room, where a band of heights is free, and which class is where. Metres, in the
// z-up frame of the map (planning.h). They are the contents of grid.pgm and semantic.png of docs/planning.md.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "panoptic/free_space.h"
#include "panoptic/labels.h"
#include "panoptic/map.h"
#include "panoptic/planning.h"

namespace panoptic {

// Cells of `rows` along y and `columns` along x; x runs fastest, and the first cell has the lowest x and y.
struct FloorGrids {
  double cell_m = 0;
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  // the corner of the first cell
  int columns = 0;
  int rows = 0;
  std::vector<Space> standing;            // from the step to the height of the agent; free also where the floor was seen
  std::vector<std::vector<Space>> bands;  // those that were asked for
  std::vector<ClassId> class_at;          // of the highest surface below the ceiling; kUnknown also where there is none
  std::vector<std::uint8_t> is_seen;      // 1: there is surface below the ceiling
};

// The grids of this map; none of them has a cell if the map has no surface. Throws Error if the agent or a band is out of range.
FloorGrids floor_grids(const PanopticMap& map, const UpFrame& frame, const AgentSize& agent = {},
                       const std::vector<HeightBand>& bands = {});

}  // namespace panoptic
