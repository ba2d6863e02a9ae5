// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The range of depths in squares of pixels. With it most bricks of a block are known to be off the surface before any of their
// voxels is projected.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/fusion/integrate_kernels.h"

namespace panoptic {

// Depths of some pixels; nearest_m > farthest_m where none has a reading. Where a pixel's band is longer than others
// (grazing.h), by so much the range is wider.
struct DepthRange {
  float nearest_m;
  float farthest_m;
  bool grazing;  // a pixel's scale is below 1
};

// Tiles of 8 x 8 pixels, and coarser levels with sides twice as long each, up to one tile for the image.
class DepthTiles {
 public:
  static constexpr int kFinestLog2_px = 3;

  struct Level {
    int columns = 0;
    int rows = 0;
    std::vector<DepthRange> tiles;  // by row
  };

  // Rows of tiles run in parallel.
  void build(const KernelFrame& frame, const Band& band);

  // Level n has tiles with sides of 8 << n pixels. Never empty once built.
  const std::vector<Level>& levels() const { return levels_; }

 private:
  std::vector<Level> levels_;
};

// The bricks of the block that may hold voxels which the frame observes: none of the others does.
BricksInBand bricks_in_band(const KernelFrame& frame, const DepthTiles& tiles, const BlockInCamera& place, const Band& band);

}  // namespace panoptic
