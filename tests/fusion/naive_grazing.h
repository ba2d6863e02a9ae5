// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The scale of signed distances at one pixel, as grazing.h defines it, in double.
#pragma once

#include <algorithm>
#include <cmath>

#include "panoptic/frame.h"
#include "panoptic/fusion/grazing.h"
#include "panoptic/fusion/registration.h"

namespace panoptic::test {

// A frame's depths as the kernels see them; labels and colours are left out.
inline KernelFrame depths_of(const Frame& frame, const RegisteredFrame& registered) {
  KernelFrame pixels;
  pixels.depth = registered.depth.data();
  pixels.width = registered.width;
  pixels.height = registered.height;
  pixels.fx = static_cast<float>(frame.depth_camera.fx);
  pixels.fy = static_cast<float>(frame.depth_camera.fy);
  pixels.cx = static_cast<float>(frame.depth_camera.cx);
  pixels.cy = static_cast<float>(frame.depth_camera.cy);
  return pixels;
}

// Inverse depths of the pixel and two to each side, along a row or a column.
struct InverseDepths {
  double far_before, before, here, after, far_after;

  double slope() const { return (far_after - far_before) / 4; }
  bool is_straight(double bent) const {
    return std::abs(far_before + far_after - 2 * here) <= bent &&
           std::abs(2 * (after - before) - (far_after - far_before)) <= bent;
  }
};

inline double naive_scale(const KernelFrame& frame, const Band& band, double voxel_size_m, int u, int v) {
  if (u < 2 || v < 2 || u >= frame.width - 2 || v >= frame.height - 2) return 1;
  bool read = true;
  const auto inverse = [&](int du, int dv) {
    const double z = frame.depth[(v + dv) * frame.width + u + du];
    read = read && z > 0;
    return 1 / z;
  };
  const InverseDepths row{inverse(-2, 0), inverse(-1, 0), inverse(0, 0), inverse(1, 0), inverse(2, 0)};
  const InverseDepths column{inverse(0, -2), inverse(0, -1), inverse(0, 0), inverse(0, 1), inverse(0, 2)};
  if (!read) return 1;
  const double bent = 2 * std::max(std::abs(row.slope()), std::abs(column.slope()));
  if (!row.is_straight(bent) || !column.is_straight(bent)) return 1;
  const Vec3d ray((u - double{frame.cx}) / double{frame.fx}, (v - double{frame.cy}) / double{frame.fy}, 1);
  Vec3d normal(row.slope() * double{frame.fx}, column.slope() * double{frame.fy}, 0);
  normal.z() = row.here - normal.x() * ray.x() - normal.y() * ray.y();
  const double cosine = row.here / (normal.norm() * ray.norm());
  const double across_voxels = double{band.truncation_m} / voxel_size_m * cosine;
  return std::clamp(across_voxels / double{kLeastAcross_voxels}, 1 / double{kLongestBand}, 1.0);
}

}  // namespace panoptic::test
