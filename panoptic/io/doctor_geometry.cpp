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

// The factor from a reading of a pixel to its depth, which is planar.
float to_planar(const Camera& camera, int u, int v, const Hypothesis& hypothesis) {
  return hypothesis.along_ray ? static_cast<float>(1 / back_project(camera, u, v, 1).norm()) : 1;
}

// to_from: where a point of `from` lies in the frame of `to`.
Counts count(const ViewPair& pair, const Pose& to_from, const Hypothesis& hypothesis) {
  const double focal_factor = hypothesis.focal_factor;
  const Eigen::Matrix3f rotation = to_from.linear().cast<float>();
  const Vec3f translation = to_from.translation().cast<float>();
  const Camera a = with_focal(pair.from.camera, focal_factor);
  const Camera b = with_focal(pair.to.camera, focal_factor);
  Counts counts;
  for (int v = 0; v < a.height; v += 2) {
    for (int u = 0; u < a.width; u += 2) {
      const float z = pair.from.depth(u, v) * to_planar(a, u, v, hypothesis);
      if (!(z > 0)) continue;
      counts.points += 1;
      const Vec3f p = rotation * back_project(a, u, v, static_cast<double>(z)).cast<float>() + translation;
      if (!(p.z() > 0)) continue;
      const double x = b.fx * static_cast<double>(p.x() / p.z()) + b.cx + 0.5;
      const double y = b.fy * static_cast<double>(p.y() / p.z()) + b.cy + 0.5;
      if (!(x >= 0 && y >= 0 && x < b.width && y < b.height)) continue;
      const int to_u = static_cast<int>(x);
      const int to_v = static_cast<int>(y);
      const float there = pair.to.depth(to_u, to_v) * to_planar(b, to_u, to_v, hypothesis);
      if (!(there > 0)) continue;
      counts.seen += 1;
      if (std::abs(there - p.z()) <= static_cast<float>(kTolerance) * there) counts.agree += 1;
    }
  }
  return counts;
}

const Pose& pose_for(const DepthView& view, Neighbour neighbour) {
  const std::optional<Pose>& other = neighbour == Neighbour::kBefore ? view.pose_before : view.pose_after;
  return neighbour != Neighbour::kNone && other ? *other : view.pose;
}

// A rotation tells its quaternion but for the sign, and that does not change what the numbers in another order are.
Pose reordered(Pose pose, QuaternionOrder order) {
  if (order == QuaternionOrder::kAsRead) return pose;
  const Eigen::Quaterniond q(pose.linear());
  pose.linear() = (order == QuaternionOrder::kWFirst ? Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w())
                                                     : Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()))
                      .toRotationMatrix();
  return pose;
}

Pose world_from_camera(const DepthView& view, const Hypothesis& hypothesis) {
  const Pose pose = reordered(pose_for(view, hypothesis.pose_of), hypothesis.convention.quaternions);
  Pose result = hypothesis.convention.inverse ? pose.inverse() : pose;
  result.linear() = result.linear() * hypothesis.convention.axes;
  return result;
}

// How much each pair says, by how far the camera moved from one frame to the other compared with the other pairs.
std::vector<double> weights(const std::vector<ViewPair>& pairs) {
  constexpr double kLeast = 0.1;
  std::vector<double> result;
  for (const ViewPair& pair : pairs) result.push_back((pair.to.pose.translation() - pair.from.pose.translation()).norm());
  const double farthest = *std::max_element(result.begin(), result.end());
  for (double& w : result) w = farthest > 0 ? kLeast + (1 - kLeast) * w / farthest : 1;
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

std::vector<Explanation> explanations(const std::vector<ViewPair>& pairs, const std::vector<Hypothesis>& hypotheses) {
  const std::vector<double> all = shares(pairs, hypotheses);
  std::vector<Explanation> result;
  for (std::size_t i = 0; i < all.size(); ++i) result.push_back({hypotheses[i], all[i]});
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.share > b.share; });
  return result;
}

// A factor of depth is as good as its inverse on the translations, where that is a usual unit.
bool is_plausible(double factor, double median_m) {
  const double step = std::log10(factor);
  const bool is_unit = std::abs(step - std::round(step)) < 1e-9;
  return is_room(median_m * factor) || (is_unit && is_room(median_m));
}

struct Candidates {
  std::vector<PoseConvention> conventions = all_conventions();
  std::vector<double> factors;
  std::vector<double> focals = {0.5, 0.625, 0.714, 0.8, 0.9, 1.1, 1.25, 1.4, 1.6, 2.0};

  explicit Candidates(double median_m) {
    for (const double factor : all_factors()) {
      if (factor != 1 && is_plausible(factor, median_m)) factors.push_back(factor);
    }
  }

  std::vector<Hypothesis> single_mistakes() const {
    std::vector<Hypothesis> result;
    for (const double factor : factors) result.push_back({.depth_factor = factor});
    for (const PoseConvention& convention : conventions) {
      if (!convention.is_declared()) result.push_back({.convention = convention});
    }
    for (const double focal : focals) result.push_back({.focal_factor = focal});
    result.push_back({.along_ray = true});
    for (const Neighbour neighbour : {Neighbour::kBefore, Neighbour::kAfter}) result.push_back({.pose_of = neighbour});
    const auto quaternions = [&](const char* name, QuaternionOrder order) {
      result.push_back({.convention = {.name = name, .quaternions = order}});
    };
    quaternions("with w first in the quaternions (qw qx qy qz)", QuaternionOrder::kWFirst);
    quaternions("with w last in the quaternions (qx qy qz qw)", QuaternionOrder::kWLast);
    return result;
  }
  std::vector<Hypothesis> two_mistakes() const {
    std::vector<Hypothesis> result;
    for (const double factor : factors) {
      for (const PoseConvention& convention : conventions) {
        if (!convention.is_declared()) result.push_back({.convention = convention, .depth_factor = factor});
      }
      for (const double focal : focals) result.push_back({.depth_factor = factor, .focal_factor = focal});
    }
    return result;
  }
};

// Depth that is too small makes every motion small, too: that says something only if no motion at all would explain less.
bool proves_its_factor(const std::vector<ViewPair>& pairs, const Explanation& e) {
  if (e.hypothesis.depth_factor <= 1) return true;
  Hypothesis still = e.hypothesis;
  still.moves = false;
  return clearly_better(agreement(pairs, still), e.share);
}

// Those of a sorted list that explain the depth clearly better than `declared`, down to what is clearly worse than the best of
// them.
std::vector<Explanation> better_ones(const std::vector<ViewPair>& pairs, const std::vector<Explanation>& sorted,
                                     double declared) {
  constexpr std::size_t kMost = 4;
  std::vector<Explanation> better;
  for (const Explanation& e : sorted) {
    if (e.share < kGoodAgreement || !clearly_better(declared, e.share) || better.size() == kMost) break;
    if (!better.empty() && clearly_better(e.share, better.front().share)) break;
    if (proves_its_factor(pairs, e)) better.push_back(e);
  }
  return better;
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

std::string in_words(const Hypothesis& h) {
  std::vector<std::string> parts;
  if (h.depth_factor != 1) parts.push_back(fmt::format("depth times {:.4g}", h.depth_factor));
  if (h.focal_factor != 1) parts.push_back(fmt::format("focal lengths times {:.4g}", h.focal_factor));
  if (h.along_ray) parts.emplace_back("depth taken along the rays");
  if (!h.convention.is_declared()) parts.push_back("poses " + h.convention.name);
  if (h.pose_of == Neighbour::kBefore) parts.emplace_back("each image with the pose of the one before");
  if (h.pose_of == Neighbour::kAfter) parts.emplace_back("each image with the pose of the one after");
  return fmt::format("{}", fmt::join(parts, " and "));
}

double agreement(const std::vector<ViewPair>& pairs, const Hypothesis& hypothesis) {
  if (pairs.empty()) return 0;
  const std::vector<double> weight = weights(pairs);
  Counts total;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Pose to_from =
        world_from_camera(pairs[i].to, hypothesis).inverse(Eigen::Affine) * world_from_camera(pairs[i].from, hypothesis);
    to_from.translation() *= hypothesis.moves ? 1 / hypothesis.depth_factor : 0;  // in units of the depth as it is
    const Counts counts = count(pairs[i], to_from, hypothesis);
    total.agree += weight[i] * counts.agree;
    total.seen += weight[i] * counts.seen;
    total.points += weight[i] * counts.points;
  }
  return total.share();
}

double agreement_without_motion(const ViewPair& pair) { return count(pair, Pose::Identity(), {}).share(); }

bool clearly_better(double share, double other) {
  constexpr double kLeastGain = 0.025;
  constexpr double kLeastRatio = 1.5;  // of what stays unexplained
  return other - share >= kLeastGain && 1 - share >= kLeastRatio * (1 - other);
}

bool is_room(double median_m) {
  constexpr double kNearest_m = 0.2;
  constexpr double kFarthest_m = 10;
  return median_m >= kNearest_m && median_m <= kFarthest_m;
}

Explanations explain(const std::vector<ViewPair>& pairs, double median_m) {
  const Candidates candidates(median_m);
  Explanations result{agreement(pairs, {}), agreement(pairs, {.moves = false}), {}};
  const std::vector<Explanation> singles = explanations(pairs, candidates.single_mistakes());
  result.better = better_ones(pairs, singles, result.declared);
  const double single = result.better.empty() ? result.declared : result.better.front().share;
  if (single >= kExplains) return result;
  const std::vector<Explanation> twice = explanations(pairs, candidates.two_mistakes());
  std::vector<Explanation> of_two = better_ones(pairs, twice, result.declared);
  if (!of_two.empty() && clearly_better(single, of_two.front().share)) result.better = std::move(of_two);
  return result;
}

}  // namespace panoptic
