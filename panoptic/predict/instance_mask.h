// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Boxes, and masks that a network gives as scores on a coarse grid: for every decoder of instances.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/image.h"
#include "panoptic/predict/model.h"
#include "panoptic/segmentation.h"

namespace panoptic {

// Edges in pixels of the colour image, where pixel u covers [u, u + 1).
struct Box {
  double left = 0;
  double top = 0;
  double right = 0;
  double bottom = 0;

  double area() const;
};

// Area in common over joint area; 0 for empty boxes.
double intersection_over_union(const Box& a, const Box& b);

// Pixels [x0, x0 + width) x [y0, y0 + height).
struct PixelRect {
  int x0 = 0;
  int y0 = 0;
  int width = 0;  // less than 1 if the box holds no pixel
  int height = 0;
};

// The pixels of the image whose centres lie in the box. The box must be finite.
PixelRect pixels_in(const Box& box, int image_width, int image_height);

// A grid of width x height cells over the image, or over a part of it: grid = (image + 0.5 - left) * cells_per_px - 0.5.
struct ScoreGrid {
  int width = 0;
  int height = 0;
  double cells_per_px_x = 1;
  double cells_per_px_y = 1;
  double left_px = 0;
  double top_px = 0;
};

// Scores of the cells [x0, x0 + width) x [y0, y0 + height) of a grid.
struct ScoreWindow {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
  std::vector<float> scores;  // row by row
};

// The window without scores that draw_mask needs for these pixels, of which there must be some.
ScoreWindow window_around(const PixelRect& rect, const ScoreGrid& grid);

// 1 where the score, interpolated bilinearly at the pixel's centre, exceeds the threshold. Of the size of the rectangle.
Image<std::uint8_t> draw_mask(const PixelRect& rect, const ScoreGrid& grid, const ScoreWindow& window, float threshold);

// p(l | O) over the classes of the label set: a network's shares of its own classes, added up where they have the same
// counterpart and divided by their sum. Those without a counterpart are left out, and what holds less than a thousandth of the
// sum.
std::vector<ClassProbability> distribution_of(const std::vector<float>& shares, const std::vector<ClassId>& class_of);

// Drops instances whose mask has less pixels than thresholds.min_area_px.
void drop_small(std::vector<Instance>& instances, const Thresholds& thresholds);

}  // namespace panoptic
