// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Square cells over a part of a plane, and what is done with sets of them: growing, shrinking, connected parts, outlines.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "panoptic/base/polygon.h"

namespace panoptic {

// Cell (x, y), numbered x + width * y, spans origin + [x, x + 1) * cell_m on the first axis, and likewise on the second.
struct FlatGrid {
  Vec2d origin = Vec2d::Zero();
  double cell_m = 1;
  int width = 0;
  int height = 0;

  std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  bool holds(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  std::size_t number(int x, int y) const {
    return static_cast<std::size_t>(x) + static_cast<std::size_t>(width) * static_cast<std::size_t>(y);
  }
  // The cell around a point; nothing outside.
  std::optional<std::size_t> cell_at(const Vec2d& point) const;
  Vec2d middle(std::size_t cell) const;
};

// The grid over an area with `margin` more cells on each side. Cells become larger where there would be more than 16 million.
FlatGrid grid_over(const Eigen::AlignedBox2d& area, double cell_m, int margin);

using CellSet = std::vector<char>;   // per cell: 1 if it belongs to the set
using CellParts = std::vector<int>;  // per cell: the number of its part from 1 on, 0 for none

// Cells whose middle lies within the polygon are added to the set.
void add_polygon(const FlatGrid& grid, const Polygon& polygon, CellSet& set);

// The cells whose middle is farther than the radius from the middle of every cell that is not in the set.
CellSet shrunk(const FlatGrid& grid, const CellSet& set, double radius_m);

// The parts whose cells touch along an edge, numbered in the order of their first cells.
CellParts connected_parts(const FlatGrid& grid, const CellSet& set);

// Gives the other cells of the set the number of the part that reaches them first, step by step within the set.
void grow_within(const FlatGrid& grid, const CellSet& set, CellParts& parts);

// The outer edge of the largest connected piece of a part, counter-clockwise; empty if there is none.
Polygon outline(const FlatGrid& grid, const CellParts& parts, int part);
// The outline of the part of a set that has the largest one; empty if the set is.
Polygon largest_outline(const FlatGrid& grid, const CellSet& set);

}  // namespace panoptic
