// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures how well depth images agree with each other under a guess of what the recording's numbers mean. The right guess
// makes the points of one frame land on the surfaces of another; a wrong scale, pose direction or axis does not.
#pragma once

#include <optional>
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
  std::optional<Pose> pose_before = {};  // of the positions beside it, if they are known
  std::optional<Pose> pose_after = {};
};
DepthView thinned(const Frame& frame, const Camera& depth_camera);

struct ViewPair {
  DepthView from;
  DepthView to;
};

// The order in which a quaternion was written, where it was read in another.
enum class QuaternionOrder { kAsRead, kWFirst, kWLast };

// A meaning that a recording's poses may have: world_from_camera = (inverse ? pose^-1 : pose) * axes.
struct PoseConvention {
  std::string name;
  bool inverse = false;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // file_from_camera: a signed permutation
  QuaternionOrder quaternions = QuaternionOrder::kAsRead;

  bool is_declared() const { return !inverse && axes.isIdentity() && quaternions == QuaternionOrder::kAsRead; }
};

enum class Neighbour { kNone, kBefore, kAfter };

struct Hypothesis {
  PoseConvention convention = {};
  double depth_factor = 1;               // true depth = factor * depth
  double focal_factor = 1;               // true focal length = factor * focal length
  Neighbour pose_of = Neighbour::kNone;  // the position whose pose is this one's
  bool moves = true;                     // false: no translation at all
  bool along_ray = false;                // depth is the distance from the camera, not from its plane
};
// "depth times 5 and poses inverse (camera from world)".
std::string in_words(const Hypothesis& hypothesis);

// The share of the points of `from` that land on a surface of `to`, of those that land in the image where there is depth.
// Pooled over the pairs, each weighed by how far the camera moved from one to the other: what only turned says nothing of scales.
// 0 to 1. Hypotheses that throw most points out of the image gain nothing by it.
double agreement(const std::vector<ViewPair>& pairs, const Hypothesis& hypothesis);

// The agreement under no motion at all: tells pairs whose motion can be seen from those that prove nothing.
double agreement_without_motion(const ViewPair& pair);

struct Explanation {
  Hypothesis hypothesis;
  double share = 0;
};

struct Explanations {
  double declared = 0;             // under the recording's own numbers
  double without_translation = 0;  // under its rotations alone
  // Guesses that explain the depth clearly better than the recording's numbers: the best one and those that noise cannot tell
  // from it, best first. Empty: there is none.
  std::vector<Explanation> better;
};

// Tries wrong divisors, all pose directions and axes, other focal lengths, and poses of the frame before or after; two mistakes
// at once only if none of these explains the depth. `median_m`: of the recording's depth. Guesses that give it a median outside
// 0.2 to 10 m are left out, but for translations in another unit.
Explanations explain(const std::vector<ViewPair>& pairs, double median_m);

// True if a median depth could be that of a room, or of a desk.
bool is_room(double median_m);

// True if the second share leaves so much less unexplained that noise cannot be the reason.
bool clearly_better(double share, double other);

// The agreement that a right guess reaches at least.
inline constexpr double kGoodAgreement = 0.7;

}  // namespace panoptic
