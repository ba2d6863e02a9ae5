// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/depth_points.h"

#include <cmath>

namespace panoptic {

std::vector<DepthPoint> depth_points(const Frame& frame, const DepthLimits& range, int stride) {
  std::vector<DepthPoint> points;
  for (int v = stride / 2; v < frame.depth.height(); v += stride) {
    const float* row = frame.depth.row(v);
    for (int u = stride / 2; u < frame.depth.width(); u += stride) {
      if (!(row[u] >= range.min_m && row[u] <= range.max_m)) continue;
      points.push_back({back_project(frame.depth_camera, u, v, double{row[u]}).cast<float>(), u, v});
    }
  }
  return points;
}

std::vector<DepthPoint> smooth_points(const Frame& frame, const DepthLimits& range, int stride) {
  constexpr int kReach_px = 3;
  std::vector<DepthPoint> points = depth_points(frame, range, stride);
  std::erase_if(points, [&](const DepthPoint& p) { return !is_smooth(frame.depth, p.u, p.v, kReach_px); });
  return points;
}

bool is_smooth(const ImageView<float>& depth, int u, int v, int stride) {
  if (u < stride || v < stride || u + stride >= depth.width() || v + stride >= depth.height()) return false;
  constexpr float kStep = 0.1F;
  const float z = depth(u, v);
  const auto near = [&](int du, int dv) { return std::abs(depth(u + du, v + dv) - z) <= kStep * z; };
  return near(-stride, 0) && near(stride, 0) && near(0, -stride) && near(0, stride);
}

}  // namespace panoptic
