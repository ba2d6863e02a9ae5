// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The distance of every spot of a home's floor from walls and furniture.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/sim/floor_rect.h"
#include "panoptic/sim/home.h"

namespace panoptic {

// A thing of the scene as a box.
struct ThingBox {
  FloorRect base;
  double bottom_m = 0;
  double top_m = 0;
  std::uint16_t instance = 0;
};

// The boxes of the scene's things (instance > 0), in the order of its objects.
std::vector<ThingBox> thing_boxes(const Scene& scene);

// The rooms' walls less the doorways, as thin rectangles.
std::vector<FloorRect> wall_rects(const Home& home);

class ClearanceMap {
 public:
  // Makes cells of `cell_m` over the area; distances are exact up to `far_m`.
  ClearanceMap(const Eigen::AlignedBox2d& area, double cell_m, double far_m);

  void add(const FloorRect& obstacle);

  int width() const { return width_; }
  int height() const { return height_; }
  int cell_at(const Eigen::Vector2d& point) const;  // the nearest one within the area
  Eigen::Vector2d middle(int cell) const;
  double operator[](int cell) const { return clearance_m_[static_cast<std::size_t>(cell)]; }
  // The distance at a point, interpolated between the middles of cells.
  double at(const Eigen::Vector2d& point) const;

 private:
  Eigen::Vector2d origin_;
  double cell_m_;
  double far_m_;
  int width_;
  int height_;
  std::vector<double> clearance_m_;
};

}  // namespace panoptic
