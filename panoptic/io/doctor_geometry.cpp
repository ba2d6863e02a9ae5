// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr int kThinnedWidth_px = 160;
constexpr double kTolerance = 0.04;     // of the depth: noise, thinning and slanted surfaces
constexpr double kMinSeenShare = 0.25;  // hypotheses that see fewer points are judged as if they saw this many
constexpr double kExplains = 0.8;       // a guess that explains less leaves room for two errors at once
constexpr double kDivisorTum = 5000;    // raw values per metre of the known sets
constexpr double kDivisorReplica = 6553.5;
constexpr double kDivisorMillimetre = 1000;

struct Counts {
  double agree = 0;
  double seen = 0;
  double points = 0;

  double share() const { return points > 0 ? agree / std::max(seen, kMinSeenShare * points) : 0; }
};

Camera with_focal(Camera camera, double factor) {
  camera.fx *= factor;
  camera.fy *= factor;
  return camera;
}

// to_from: where a point of `from` lies in the frame of `to`.
Counts count(const ViewPair& pair, const Pose& to_from, double focal_factor) {
  const Eigen::Matrix3f rotation = to_from.linear().cast<float>();
  const Vec3f translation = to_from.translation().cast<float>();
  const Camera a = with_focal(pair.from.camera, focal_factor);
  const Camera b = with_focal(pair.to.camera, focal_factor);
  Counts counts;
  for (int v = 0; v < a.height; v += 2) {
    for (int u = 0; u < a.width; u += 2) {
      const float z = pair.from.depth(u, v);
      if (!(z > 0)) continue;
      counts.points += 1;
      const Vec3f p = rotation * back_project(a, u, v, static_cast<double>(z)).cast<float>() + translation;
      if (!(p.z() > 0)) continue;
      const double x = b.fx * static_cast<double>(p.x() / p.z()) + b.cx + 0.5;
      const double y = b.fy * static_cast<double>(p.y() / p.z()) + b.cy + 0.5;
      if (!(x >= 0 && y >= 0 && x < b.width && y < b.height)) continue;
      const float there = pair.to.depth(static_cast<int>(x), static_cast<int>(y));
      if (!(there > 0)) continue;
      counts.seen += 1;
      if (std::abs(there - p.z()) <= static_cast<float>(kTolerance) * there) counts.agree += 1;
    }
  }
  return counts;
}

Pose world_from_camera(const Pose& pose, const PoseConvention& convention) {
  Pose result = convention.inverse ? pose.inverse() : pose;
  result.linear() = result.linear() * convention.axes;
  return result;
}

std::string axes_name(const Eigen::Matrix3d& axes) {
  if (axes.isIdentity()) return "as declared";
  if (axes.isApprox(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix())) return "with y and z flipped (OpenGL camera axes)";
  constexpr std::array<const char*, 6> kNames = {"x", "y", "z", "-x", "-y", "-z"};
  std::array<const char*, 3> names{};
  for (int column = 0; column < 3; ++column) {
    Eigen::Index row = 0;
    axes.col(column).cwiseAbs().maxCoeff(&row);
    const double sign = axes(row, column);
    names.at(static_cast<std::size_t>(column)) = kNames.at(static_cast<std::size_t>(sign > 0 ? row : row + 3));
  }
  return fmt::format("with camera axes right, down, forward = {}, {}, {}", names[0], names[1], names[2]);
}

Eigen::Matrix3d signed_permutation(const std::array<int, 3>& order, unsigned negative) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  for (unsigned column = 0; column < order.size(); ++column)
    axes(order.at(column), column) = (negative >> column & 1U) != 0 ? -1 : 1;
  return axes;
}

PoseConvention named(const Eigen::Matrix3d& axes, bool inverse) {
  const std::string name = axes_name(axes);
  if (!inverse) return {name, inverse, axes};
  return {axes.isIdentity() ? "inverse (camera from world)" : "inverse (camera from world), " + name, inverse, axes};
}

// Every way to name the three axes, mirrored ones too, for poses and inverse poses. The declared one comes first.
std::vector<PoseConvention> all_conventions() {
  constexpr unsigned kSigns = 8;
  std::vector<PoseConvention> conventions;
  for (const bool inverse : {false, true}) {
    std::array<int, 3> order = {0, 1, 2};
    do {
      for (unsigned negative = 0; negative < kSigns; ++negative) {
        conventions.push_back(named(signed_permutation(order, negative), inverse));
      }
    } while (std::next_permutation(order.begin(), order.end()));
  }
  return conventions;
}

// Wrong divisors seen in practice, and whole steps for those that are not.
std::vector<double> all_factors() {
  constexpr double kReplicaForTum = kDivisorReplica / kDivisorTum;
  std::vector<double> factors = {1};
  for (const double f :
       {kReplicaForTum, 2.0, 4.0, kDivisorTum / kDivisorMillimetre, kDivisorReplica / kDivisorMillimetre, 10.0, 100.0, 1000.0}) {
    factors.push_back(f);
    factors.push_back(1 / f);
  }
  return factors;
}

std::vector<double> shares(const std::vector<ViewPair>& pairs, const std::vector<Hypothesis>& hypotheses) {
  std::vector<double> result(hypotheses.size());
  parallel_for(hypotheses.size(), [&](std::size_t i) { result[i] = agreement(pairs, hypotheses[i]); });
  return result;
}

// The first of equals: the declared values, which come first, if nothing is better.
Explanation best_of(const std::vector<ViewPair>& pairs, const std::vector<Hypothesis>& hypotheses) {
  const std::vector<double> all = shares(pairs, hypotheses);
  const auto at = std::max_element(all.begin(), all.end());
  return {hypotheses[static_cast<std::size_t>(at - all.begin())], *at};
}

}  // namespace

DepthView thinned(const Frame& frame, const Camera& depth_camera) {
  const int step = std::max(1, (depth_camera.width + kThinnedWidth_px - 1) / kThinnedWidth_px);
  const Camera camera{(depth_camera.width + step - 1) / step,
                      (depth_camera.height + step - 1) / step,
                      depth_camera.fx / step,
                      depth_camera.fy / step,
                      depth_camera.cx / step,
                      depth_camera.cy / step};
  DepthView view{camera, frame.world_from_camera, Image<float>(camera.width, camera.height)};
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) view.depth(u, v) = frame.depth(u * step, v * step);
  }
  return view;
}

double agreement(const std::vector<ViewPair>& pairs, const Hypothesis& hypothesis) {
  Counts total;
  for (const ViewPair& pair : pairs) {
    Pose to_from = world_from_camera(pair.to.pose, hypothesis.convention).inverse(Eigen::Affine) *
                   world_from_camera(pair.from.pose, hypothesis.convention);
    to_from.translation() /= hypothesis.depth_factor;  // in units of the depth as it is
    const Counts counts = count(pair, to_from, hypothesis.focal_factor);
    total.agree += counts.agree;
    total.seen += counts.seen;
    total.points += counts.points;
  }
  return total.share();
}

double agreement_without_motion(const ViewPair& pair) { return count(pair, Pose::Identity(), 1).share(); }

bool clearly_better(double share, double other) {
  constexpr double kLeastGain = 0.025;
  constexpr double kLeastRatio = 1.5;  // of what stays unexplained
  return other - share >= kLeastGain && 1 - share >= kLeastRatio * (1 - other);
}

Explanations explain(const std::vector<ViewPair>& pairs) {
  const std::vector<PoseConvention> conventions = all_conventions();
  const std::vector<double> factors = all_factors();
  const PoseConvention& declared = conventions.front();
  std::vector<Hypothesis> by_factor;
  std::vector<Hypothesis> by_convention;
  std::vector<Hypothesis> by_focal;
  for (const double factor : factors) by_factor.push_back({declared, factor, 1});
  for (const PoseConvention& convention : conventions) by_convention.push_back({convention, 1, 1});
  for (const double factor : {1.0, 0.5, 0.625, 0.714, 0.8, 0.9, 1.1, 1.25, 1.4, 1.6, 2.0})
    by_focal.push_back({declared, 1, factor});

  Explanations result{agreement(pairs, by_factor.front()),
                      best_of(pairs, by_factor),
                      best_of(pairs, by_convention),
                      best_of(pairs, by_focal),
                      {}};
  const double single = std::max({result.depth_factor.share, result.convention.share, result.focal_factor.share});
  if (single < kExplains) {
    std::vector<Hypothesis> by_both;
    for (const PoseConvention& convention : conventions) {
      for (const double factor : factors) by_both.push_back({convention, factor, 1});
    }
    result.both = best_of(pairs, by_both);
  }
  return result;
}

}  // namespace panoptic
