// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures how well depth images agree with each other under a guess of what the recording's numbers mean. The right guess
// makes the points of one frame land on the surfaces of another; a wrong scale, pose direction or axis does not.
#pragma once

#include <string>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/geometry.h"
#include "panoptic/image.h"

namespace panoptic {

// One frame's depth, thinned out to about 160 pixels across.
struct DepthView {
  Camera camera;
  Pose pose;  // as the recording has it
  Image<float> depth;
};
DepthView thinned(const Frame& frame, const Camera& depth_camera);

struct ViewPair {
  DepthView from;
  DepthView to;
};

// A meaning that a recording's poses may have: world_from_camera = (inverse ? pose^-1 : pose) * axes.
struct PoseConvention {
  std::string name;
  bool inverse = false;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // file_from_camera: a signed permutation
};

struct Hypothesis {
  PoseConvention convention;
  double depth_factor = 1;  // true depth = factor * depth
  double focal_factor = 1;  // true focal length = factor * focal length
};

// The share of the points of `from` that land on a surface of `to`, of those that land in the image where there is depth.
// Pooled over the pairs; 0 to 1. Hypotheses that throw most points out of the image gain nothing by it.
double agreement(const std::vector<ViewPair>& pairs, const Hypothesis& hypothesis);

// The agreement under no motion at all: tells pairs whose motion can be seen from those that prove nothing.
double agreement_without_motion(const ViewPair& pair);

struct Explanation {
  Hypothesis hypothesis;
  double share = 0;
};

// The best guess of each kind; the declared values are among each kind's, so no share is below the declared one.
struct Explanations {
  double declared = 0;
  Explanation depth_factor;  // everything else as declared
  Explanation convention;    // everything else as declared
  Explanation focal_factor;  // everything else as declared
  Explanation both;          // convention and depth factor together; tried only if none of them alone explains the depth
};
Explanations explain(const std::vector<ViewPair>& pairs);

// True if the second share leaves so much less unexplained that noise cannot be the reason.
bool clearly_better(double share, double other);

}  // namespace panoptic
