// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The last step that every reader shares: from what was stored to a checked Frame, or the reason why there is none.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "panoptic/io/calibration.h"
#include "panoptic/source.h"

namespace panoptic {

struct RawFrame {
  std::int64_t number = 0;
  double time_s = 0;
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();  // as stored: world from the camera that the poses are of
  Image<float> depth;                                  // metres
  Image<Rgb> color;
  Image<float> depth_weight = {};  // Frame::depth_weight
};

ReadResult skipped(std::int64_t number, std::string reason);

// Refuses a pose that is not finite, or further than 5 % from a rotation.
Outcome check_pose(const Eigen::Matrix4d& pose);

// Frame::world_from_camera for a stored pose that check_pose lets through.
Pose camera_pose(const Eigen::Matrix4d& pose, const Calibration& calibration);

// Raw values to metres; 0, negative, NaN and the invalid values become 0.
Image<float> to_metres(const Image<std::uint16_t>& raw, const Calibration& calibration);
Image<float> to_metres(Image<float> raw, const Calibration& calibration);

// Checks pose and image sizes against the fitted calibration, and removes the distortion of the lenses.
ReadResult finish(RawFrame raw, const Calibration& calibration);

}  // namespace panoptic
