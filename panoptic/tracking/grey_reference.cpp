// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/grey_reference.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "panoptic/tracking/projection.h"

namespace panoptic {
namespace {

constexpr std::size_t kMostPoints = 3000;  // a level
constexpr float kLeastGradient = 2;        // grey levels a pixel: less is noise

struct Candidate {
  GreyPoint point;
  float gradient = 0;
};

std::vector<Candidate> candidates(const Frame& frame, const GreyLevel& level, const DepthLimits& range) {
  const int stride = std::max(1, frame.depth.width() / std::max(level.grey.width(), 1));
  const Pose color_from_depth = frame.color_from_depth;
  std::vector<Candidate> found;
  for (const DepthPoint& p : depth_points(frame, range, stride)) {
    if (!is_smooth(frame.depth, p.u, p.v, std::max(2, stride / 2))) continue;
    const Vec3d in_color = color_from_depth * p.in_camera.cast<double>();
    if (!(in_color.z() > 0)) continue;
    const Eigen::Vector2f pixel = project(level.camera, in_color).cast<float>();
    if (!is_inside(level.grey, pixel.x(), pixel.y())) continue;
    const GreySample s = sample(level.grey, pixel.x(), pixel.y());
    const float gradient = std::hypot(s.right, s.down);
    if (gradient >= kLeastGradient) found.push_back({{p.in_camera, s.value}, gradient});
  }
  return found;
}

// The points with the largest gradients, in the order of their pixels.
std::vector<GreyPoint> strongest(const std::vector<Candidate>& candidates) {
  float least = 0;
  if (candidates.size() > kMostPoints) {
    std::vector<float> gradients;
    for (const Candidate& c : candidates) gradients.push_back(c.gradient);
    const auto last = gradients.begin() + kMostPoints - 1;
    std::nth_element(gradients.begin(), last, gradients.end(), std::greater<>());
    least = *last;
  }
  std::vector<GreyPoint> points;
  for (const Candidate& c : candidates) {
    if (c.gradient >= least) points.push_back(c.point);
  }
  return points;
}

}  // namespace

GreyReference grey_reference(const Frame& frame, const std::vector<GreyLevel>& pyramid, const DepthLimits& range) {
  GreyReference reference;
  reference.world_from_camera = frame.world_from_camera;
  for (const GreyLevel& level : pyramid) reference.levels.push_back(strongest(candidates(frame, level, range)));
  return reference;
}

}  // namespace panoptic
