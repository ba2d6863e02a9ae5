// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The moments of one body, one activity after the other, at 30 frames a second.
#pragma once

#include <vector>

#include "panoptic/sim/movers.h"

namespace panoptic {

// Appends what a body does next; it goes on from the last moment. REQUIRES at least one moment.
class MoverTrack {
 public:
  explicit MoverTrack(const BodyPose& start) : poses({start}), activities({Activity::kStanding}) {}

  void stand(double seconds);
  // Turns round first where the way leads backwards. The way begins where the body is.
  void walk(const std::vector<Eigen::Vector2d>& way, double speed_m_per_s);
  void turn_to(double heading);
  // Sits down on what is behind the body, stays and gets up.
  void sit(const Vec3d& seat, double seconds);
  void lie(double seconds);

  std::vector<BodyPose> poses;
  std::vector<Activity> activities;

 private:
  void add(const BodyPose& pose, Activity activity);
  void lower(double from, double to, double seconds, Activity activity);
};

}  // namespace panoptic
