// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Images and poses with time stamps that do not agree.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic {

// Between the images of a pair unless the user says otherwise, and to the nearest pose.
constexpr double kMaxTimeDifference_s = 0.02;

// Poses of a moving device are interpolated between neighbours that are closer. At 2 m/s^2 a straight line is then off by 10 mm
// at most.
constexpr double kMaxPoseGap_s = 0.2;

// Indices into two lists; nothing = no partner.
struct TimePair {
  std::optional<std::size_t> color;
  std::optional<std::size_t> depth;
};

// The smallest time differences first; each image is used once. REQUIRES sorted times.
std::vector<TimePair> paired_by_time(const std::vector<double>& color_s, const std::vector<double>& depth_s, double tolerance_s);

struct PoseSample {
  double time_s = 0;
  Vec3d position = Vec3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

// The pose of this time; else between the poses before and after it (positions linearly, rotations along the shortest way: slerp)
// if they are less than `bracket_s` apart; else the nearest one within kMaxTimeDifference_s. REQUIRES poses sorted by time.
std::optional<Eigen::Matrix4d> pose_at(const std::vector<PoseSample>& poses, double time_s, double bracket_s);

}  // namespace panoptic
