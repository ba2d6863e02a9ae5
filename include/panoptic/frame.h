// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One posed RGB-D frame.
#pragma once

#include <cstdint>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/outcome.h"

namespace panoptic {

struct Frame {
  std::int64_t index = 0;  // the frame's number in its recording
  double time_s = 0;
  Camera depth_camera;
  Camera color_camera;                        // may differ from the depth camera in size, intrinsics and place
  Pose color_from_depth = Pose::Identity();   // a point of the depth camera's frame in the colour camera's frame
  Pose world_from_camera = Pose::Identity();  // the depth camera
  Image<float> depth;                         // metres, planar z, 0 = no reading
  Image<Rgb> color;                           // as the colour camera saw it
};

// Whether a frame can be used: not with a NaN pose, images of the wrong size, no colour, or no depth reading at all.
Outcome check(const Frame& frame);

}  // namespace panoptic
