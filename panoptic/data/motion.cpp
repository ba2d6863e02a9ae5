// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/data/motion.h"

namespace panoptic {

Pose moved_by(const Vector6d& motion) {
  Pose pose = Pose::Identity();
  pose.translation() = motion.head<3>();
  const double angle = motion.tail<3>().norm();
  if (angle > 0) pose.linear() = Eigen::AngleAxisd(angle, motion.tail<3>() / angle).toRotationMatrix();
  return pose;
}

Vector6d motion_of(const Pose& pose) {
  const Eigen::AngleAxisd turn(pose.linear());
  Vector6d motion;
  motion << pose.translation(), turn.angle() * turn.axis();
  return motion;
}

Pose scaled(const Pose& motion, double share) { return moved_by(share * motion_of(motion)); }

PoseDifference difference(const Pose& a, const Pose& b) {
  const Pose step = a.inverse() * b;
  return {step.translation().norm(), Eigen::AngleAxisd(step.linear()).angle()};
}

}  // namespace panoptic
