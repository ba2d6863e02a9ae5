// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The plan that GridFilter makes for a set of points: the order of the axes, the places between the passes, and the lines of
// each pass.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/crf/bit_grid.h"
#include "panoptic/crf/grid_filter.h"

namespace panoptic {

// The points with their axes in the order of the passes, x first, and the places where values are needed after the first and
// after the second pass. All numbered.
struct GridPlaces {
  BitGrid points;
  BitGrid after_first;
  BitGrid after_middle;
  std::vector<std::uint32_t> voxel_of;     // by number of a point: its place in the list that was given
  std::vector<std::uint32_t> middle_rows;  // by y and z: the number of the first place after the second pass

  // Those are numbered in the order of (y, z, x): a slice of the last pass finds its own side by side.
  std::uint32_t middle_row(std::int32_t y, std::int32_t z) const {
    return middle_rows[static_cast<std::size_t>(y) * static_cast<std::size_t>(points.box().size.z) + static_cast<std::size_t>(z)];
  }
};
GridPlaces find_places(std::span<const GridPoint> points, std::int32_t radius);

// The lines of one pass in one slice. Rows of points are voxels; rows of places count within the slice after the first pass, and
// within all slices after the second.
GridLines first_lines(const GridPlaces& places, std::int32_t z, std::int32_t radius);
GridLines middle_lines(const GridPlaces& places, std::int32_t z, std::int32_t radius);
LastLines last_lines(const GridPlaces& places, std::int32_t y, std::int32_t radius);

}  // namespace panoptic
