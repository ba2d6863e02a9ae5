// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/rigid_fit.h"

#include <array>

#include "panoptic/tracking/alignment_terms.h"
#include "panoptic/tracking/draws.h"

namespace panoptic {
namespace {

constexpr std::size_t kSample = 3;
constexpr int kDraws = 400;
constexpr double kSigmas = 3;
constexpr double kPixel_rad = 0.004;  // a corner is found to one or two pixels of the level in which it is looked for

// How far apart two looks at one point may put it.
double tolerance_m(const Vec3f& a, const Vec3f& b) {
  const float z = std::max(a.z(), b.z());
  return kSigmas * (double{depth_noise_m(z)} + kPixel_rad * double{z});
}

struct Matched {
  const std::vector<Feature>& a;
  const std::vector<Feature>& b;

  const Vec3f& first(const FeatureMatch& m) const { return a[m.a].in_camera; }
  const Vec3f& second(const FeatureMatch& m) const { return b[m.b].in_camera; }
};

Pose solve(const Matched& points, const std::vector<FeatureMatch>& matches) {
  Eigen::Matrix3Xd to(3, matches.size());
  Eigen::Matrix3Xd from(3, matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    to.col(column) = points.first(matches[i]).cast<double>();
    from.col(column) = points.second(matches[i]).cast<double>();
  }
  return Pose(Eigen::umeyama(from, to, false));
}

std::vector<FeatureMatch> inliers_of(const Pose& a_from_b, const Matched& points, const std::vector<FeatureMatch>& matches) {
  std::vector<FeatureMatch> inliers;
  for (const FeatureMatch& m : matches) {
    const Vec3f& a = points.first(m);
    const Vec3f& b = points.second(m);
    if ((a_from_b * b.cast<double>() - a.cast<double>()).norm() <= tolerance_m(a, b)) inliers.push_back(m);
  }
  return inliers;
}

// Three matches whose points are as far apart in one frame as in the other.
bool is_congruent(const Matched& points, const std::vector<FeatureMatch>& sample) {
  constexpr double kLeast_m = 0.05;
  for (std::size_t i = 0; i < kSample; ++i) {
    const FeatureMatch& p = sample[i];
    const FeatureMatch& q = sample[(i + 1) % kSample];
    const double in_a = double{(points.first(p) - points.first(q)).norm()};
    const double in_b = double{(points.second(p) - points.second(q)).norm()};
    if (in_a < kLeast_m || std::abs(in_a - in_b) > tolerance_m(points.first(p), points.second(p))) return false;
  }
  return true;
}

}  // namespace

RigidFit fit_rigid(const std::vector<Feature>& a, const std::vector<Feature>& b, const std::vector<FeatureMatch>& matches) {
  RigidFit best;
  if (matches.size() < kSample) return best;
  const Matched points{a, b};
  Draws draws(matches.size());
  const auto draw = [&] { return static_cast<std::size_t>((draws.next() >> 33) % matches.size()); };
  std::vector<FeatureMatch> inliers;
  for (int n = 0; n < kDraws; ++n) {
    std::vector<FeatureMatch> sample;
    for (std::size_t i = 0; i < kSample; ++i) sample.push_back(matches[draw()]);
    if (!is_congruent(points, sample)) continue;
    std::vector<FeatureMatch> agreeing = inliers_of(solve(points, sample), points, matches);
    if (agreeing.size() > inliers.size()) inliers = std::move(agreeing);
  }
  if (inliers.size() < kSample) return best;
  for (int refinement = 0; refinement < 3; ++refinement) {
    best.a_from_b = solve(points, inliers);
    std::vector<FeatureMatch> agreeing = inliers_of(best.a_from_b, points, matches);
    best.inliers = agreeing.size();
    if (agreeing.size() < kSample || agreeing.size() == inliers.size()) break;
    inliers = std::move(agreeing);
  }
  return best;
}

}  // namespace panoptic
