// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The pose of a frame from the map: its depth on the map's surface (point to plane, as Newcombe et al. 2011 and Bylow et al.
// 2013), and its brightness as an earlier frame had it (Steinbruecker et al. 2011), both robust and from coarse to fine.
#pragma once

#include <vector>

#include "panoptic/data/motion.h"
#include "panoptic/frame.h"
#include "panoptic/tracking/grey_reference.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

struct AlignmentTask {
  const Frame& frame;                     // its pose is not looked at
  const std::vector<GreyLevel>& pyramid;  // of its colour image
  const VoxelMap& map;
  const GreyReference* reference = nullptr;  // nullptr: depth alone
  DepthLimits range;
};

// A frame's finest grid of readings has this many across the image, or all that it has. Both axes have the same stride.
inline constexpr int kReadingsAcross = 160;
int stride_for(const Frame& frame, int readings_across);

// A pose, and how well it fits.
struct Alignment {
  Pose world_from_camera = Pose::Identity();
  std::size_t readings = 0;                    // depth readings that were compared
  double surface_share = 0;                    // of those, the ones near surface of the map
  double agreeing_share = 0;                   // of these, the ones that lie on it as well as the sensor can tell
  double grey_correlation = 0;                 // of the brightness with the reference's; 0 if nothing was compared
  std::size_t grey_points = 0;                 // of the reference that were compared
  double grey_share = 1;                       // of all of its points; 1 if it has none
  Matrix6d covariance = Matrix6d::Identity();  // of the motion (motion.h) that the pose may be off by
};

// The best pose near `start`. The same for any number of threads.
Alignment align(const AlignmentTask& task, const Pose& start);

}  // namespace panoptic
