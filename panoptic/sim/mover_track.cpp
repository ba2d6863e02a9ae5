// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/mover_track.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "panoptic/error.h"
#include "panoptic/sim/sensor_noise.h"
#include "panoptic/sim/walk.h"

namespace panoptic {
namespace {

constexpr double kFrame_s = 1 / kFrameRate_hz;
constexpr double kTurn_rad_per_s = 3.2;
constexpr double kAhead_m = 0.3;     // one looks so far along one's way
constexpr double kSpeedUp_m = 0.35;  // until one walks at full speed, and before one stands again
constexpr double kFullStride = 0.4;  // m/s from which on steps are whole
constexpr double kTurnFirst_rad = 0.6;

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

double turned(double heading, double towards) {
  const double most = kTurn_rad_per_s * kFrame_s;
  return heading + std::clamp(wrapped(towards - heading), -most, most);
}

Eigen::Vector2d point_at(const std::vector<Eigen::Vector2d>& way, double along_m) {
  const double step = std::clamp(along_m / kStep_m, 0.0, static_cast<double>(way.size() - 1));
  const std::size_t i = std::min(static_cast<std::size_t>(step), way.size() - 1);
  const std::size_t next = std::min(i + 1, way.size() - 1);
  return way[i] + (way[next] - way[i]) * (step - static_cast<double>(i));
}

double heading_at(const std::vector<Eigen::Vector2d>& way, double along_m, double otherwise) {
  const Eigen::Vector2d ahead = point_at(way, along_m + kAhead_m) - point_at(way, along_m);
  return ahead.norm() < 0.02 ? otherwise : std::atan2(ahead.y(), ahead.x());
}

int frames_in(double seconds) { return std::max(1, static_cast<int>(std::lround(seconds * kFrameRate_hz))); }

}  // namespace

void MoverTrack::add(const BodyPose& pose, Activity activity) {
  poses.push_back(pose);
  activities.push_back(activity);
}

void MoverTrack::stand(double seconds) {
  BodyPose pose = poses.back();
  pose.stride = 0;
  for (int i = 0; i < frames_in(seconds); ++i) add(pose, Activity::kStanding);
}

void MoverTrack::turn_to(double heading) {
  BodyPose pose = poses.back();
  pose.stride = 0;
  while (std::abs(wrapped(heading - pose.heading)) > 0.02) {
    pose.heading = turned(pose.heading, heading);
    add(pose, Activity::kStanding);
  }
}

void MoverTrack::walk(const std::vector<Eigen::Vector2d>& way, double speed_m_per_s) {
  PANOPTIC_ASSERT(!way.empty() && speed_m_per_s > 0);
  const double length_m = static_cast<double>(way.size() - 1) * kStep_m;
  const double first = heading_at(way, 0, poses.back().heading);
  if (std::abs(wrapped(first - poses.back().heading)) > kTurnFirst_rad) turn_to(first);
  BodyPose pose = poses.back();
  for (double along_m = 0; along_m < length_m - 1e-6;) {
    const double ramp = std::min({1.0, (along_m + 0.06) / kSpeedUp_m, (length_m - along_m + 0.06) / kSpeedUp_m});
    const double speed = speed_m_per_s * ramp;
    const double step_m = std::min(speed * kFrame_s, length_m - along_m);
    along_m += step_m;
    pose.at = point_at(way, along_m);
    pose.walked_m += step_m;
    pose.stride = std::min(1.0, speed / kFullStride);
    pose.heading = turned(pose.heading, heading_at(way, along_m, pose.heading));
    add(pose, Activity::kWalking);
  }
}

void MoverTrack::lower(double from, double to, double seconds, Activity activity) {
  BodyPose pose = poses.back();
  pose.stride = 0;
  const int frames = frames_in(seconds);
  for (int i = 1; i <= frames; ++i) {
    const double t = static_cast<double>(i) / frames;
    pose.down = from + (to - from) * t * t * (3 - 2 * t);
    add(pose, activity);
  }
}

void MoverTrack::sit(const Vec3d& seat, double seconds) {
  poses.back().seat = seat;
  lower(0, 1, 1.3, Activity::kSitting);
  BodyPose pose = poses.back();
  for (int i = 0; i < frames_in(seconds); ++i) add(pose, Activity::kSitting);
  lower(1, 0, 1.1, Activity::kSitting);
}

void MoverTrack::lie(double seconds) {
  lower(0, 1, 0.8, Activity::kLying);
  const BodyPose pose = poses.back();
  for (int i = 0; i < frames_in(seconds); ++i) add(pose, Activity::kLying);
  lower(1, 0, 0.7, Activity::kLying);
}

}  // namespace panoptic
