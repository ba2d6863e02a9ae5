// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The two residuals of frame alignment, and their derivatives by the camera's motion (motion.h).
#pragma once

#include <span>

#include "panoptic/tracking/frame_alignment.h"
#include "panoptic/tracking/least_squares.h"

namespace panoptic {

// The standard deviation of a depth reading: of the Kinect (Khoshelham and Elberink 2012: 1.4 mm at 1 m, by the square of the
// depth), and never below what a voxel's mean is worth.
inline float depth_noise_m(float depth_m) { return 0.001F + 0.002F * depth_m * depth_m; }

struct SurfaceSums {
  LeastSquares<6> sums;      // of the points that are near surface
  std::size_t agreeing = 0;  // of these, within three standard deviations
};

// Distances of points from the map's surface. One counts less the more it exceeds `wide_m` and three standard deviations.
SurfaceSums surface_terms(std::span<const DepthPoint> points, const VoxelMap& map, const Pose& world_from_camera, float wide_m);

// A change of exposure: grey = (1 + gain) * grey of the reference + offset.
struct Exposure {
  double gain = 0;
  double offset = 0;
};

struct GreySums {
  LeastSquares<8> sums;  // motion, gain, offset; of the points that are compared
  // For the correlation.
  double now = 0;
  double then = 0;
  double now_now = 0;
  double then_then = 0;
  double now_then = 0;
  double correlation() const;
};

// Differences between the brightness of a reference's points and that of the frame where it sees them.
GreySums grey_terms(const AlignmentTask& task, std::size_t level, const Pose& world_from_camera, const Exposure& exposure);

}  // namespace panoptic
