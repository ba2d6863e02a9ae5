// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The look of a frame, to be compared with later ones: points whose brightness differs from that of their surroundings.
#pragma once

#include <vector>

#include "panoptic/tracking/depth_points.h"
#include "panoptic/tracking/grey_pyramid.h"

namespace panoptic {

struct GreyPoint {
  Vec3f in_camera = Vec3f::Zero();  // of the frame's depth camera
  float grey = 0;
};

struct GreyReference {
  Pose world_from_camera = Pose::Identity();
  std::vector<std::vector<GreyPoint>> levels;  // as those of the pyramid
};

GreyReference grey_reference(const Frame& frame, const std::vector<GreyLevel>& pyramid, const DepthLimits& range);

}  // namespace panoptic
