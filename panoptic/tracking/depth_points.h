// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The points that a depth image shows, on coarser grids of pixels.
#pragma once

#include <vector>

#include "panoptic/frame.h"

namespace panoptic {

// Readings outside [min, max] count as missing.
struct DepthLimits {
  float min_m = 0.1F;
  float max_m = 8;
};

struct DepthPoint {
  Vec3f in_camera = Vec3f::Zero();
  int u = 0;
  int v = 0;
};

// Every `stride`-th pixel of every `stride`-th row that has a reading, row by row.
std::vector<DepthPoint> depth_points(const Frame& frame, const DepthLimits& range, int stride);

// The same without those at the edge of something: there the sensor measures neither what is in front nor what is behind.
std::vector<DepthPoint> smooth_points(const Frame& frame, const DepthLimits& range, int stride);

// Whether the depth around a pixel is that of one surface: no neighbour `stride` away is missing, or deeper or nearer by more
// than a tenth.
bool is_smooth(const ImageView<float>& depth, int u, int v, int stride);

}  // namespace panoptic
