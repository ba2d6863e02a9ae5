// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How far a camera sees in rectangles of pixels, in tiles of 8 x 8.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "panoptic/fusion/boxes_in_view.h"

namespace panoptic {

class SightTiles {
 public:
  static constexpr int kLog2_px = 3;

  // Depth in metres by row, 0 = no reading. Rows of tiles run in parallel.
  void build(const float* depth_m, int width, int height);

  // All of these look at whole tiles, those that the pixels lie in, and REQUIRE pixels in the image.
  // The least depth, 0 if any of their pixels has no reading.
  float certain_m(const PixelArea& pixels) const { return over<&Level::certain, true>(pixels); }
  // The least reading; infinity if there is none.
  float nearest_m(const PixelArea& pixels) const { return over<&Level::nearest, true>(pixels); }
  // The farthest tile: the largest of the least readings of tiles; 0 if there is none.
  float farthest_m(const PixelArea& pixels) const { return over<&Level::farthest, false>(pixels); }
  // The share of pixels that have no reading.
  float missing(const PixelArea& pixels) const;

 private:
  // By tile: of the 2^n x 2^n tiles from here on, as far as there are any; two by two of them cover any rectangle that is up
  // to twice as long.
  struct Level {
    std::vector<float> certain;
    std::vector<float> nearest;
    std::vector<float> farthest;
  };

  template <std::vector<float> Level::*Plane, bool Least>
  float over(const PixelArea& pixels) const;
  void build_row(const float* depth_m, int width, int height, int row);

  int columns_ = 0;
  int rows_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::vector<Level> levels_;
  // Pixels without reading in the tiles above and to the left: columns + 1 by rows + 1.
  std::vector<std::int32_t> missing_;
};

}  // namespace panoptic
