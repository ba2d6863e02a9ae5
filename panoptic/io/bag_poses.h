// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The poses of a bag's depth camera, from transforms, odometry or poses.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "panoptic/io/bag_roles.h"
#include "panoptic/io/bag_transforms.h"

namespace panoptic {

// All transforms of a bag. Messages that cannot be read are counted in `damaged`.
TransformTree transforms_of(const Bag& bag, const std::vector<RoledTopic>& roles, std::size_t& damaged);

struct BagPoses {
  TransformTree tree;
  std::vector<std::string> chain;                                  // from the depth camera to the world; empty: `poses` are used
  std::vector<PoseSample> poses;                                   // of a frame of the robot, or of the camera
  Eigen::Matrix4d posed_from_depth = Eigen::Matrix4d::Identity();  // from the depth camera to that frame
  std::string source;                                              // "TF: map <- base <- camera", for messages
  std::vector<std::string> assumed;

  // World from the depth camera.
  std::optional<Eigen::Matrix4d> at(double time_s) const;
};

// The transforms if they move the depth camera, else the only topic of poses. Throws Error where there are none, several, or
// where frames are not connected.
BagPoses poses_of(const Bag& bag, const std::vector<RoledTopic>& roles, const BagRoles& chosen, TransformTree tree);

}  // namespace panoptic
