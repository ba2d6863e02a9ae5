// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/map_alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace panoptic {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vec6d = Eigen::Matrix<double, 6, 1>;

// Centres of objects that were seen from different sides are off by about this much.
constexpr double kCenterError_m = 0.3;
constexpr double kNearest_m = 0.8;   // two objects that are nearer to each other say little of the turn
constexpr double kFarthest_m = 8.0;  // a large room: pairs beyond would only be more of them

constexpr std::size_t kMostPairs = 4000;  // of two classes: a hall with hundreds of chairs has a million

// Two landmarks of one map.
struct LandmarkPair {
  Vec3d from = Vec3d::Zero();
  Vec3d to = Vec3d::Zero();

  Vec3d step() const { return to - from; }
  double length_m() const { return step().head<2>().norm(); }
};

using ClassPair = std::pair<ClassId, ClassId>;

// The shortest ones of each two classes, ascending by length, and both ways if the classes are the same.
std::map<ClassPair, std::vector<LandmarkPair>> pairs_of(const std::vector<Landmark>& landmarks) {
  std::map<ClassPair, std::vector<LandmarkPair>> pairs;
  for (const Landmark& from : landmarks) {
    for (const Landmark& to : landmarks) {
      const LandmarkPair pair{from.at, to.at};
      if (from.class_id > to.class_id || pair.length_m() < kNearest_m || pair.length_m() > kFarthest_m) continue;
      pairs[{from.class_id, to.class_id}].push_back(pair);
    }
  }
  for (auto& [classes, list] : pairs) {
    std::stable_sort(list.begin(), list.end(),
                     [](const LandmarkPair& a, const LandmarkPair& b) { return a.length_m() < b.length_m(); });
    list.resize(std::min(list.size(), kMostPairs));
  }
  return pairs;
}

// The turn about the vertical and the shift by which one pair lies on the other.
Pose pose_between(const LandmarkPair& a, const LandmarkPair& b) {
  const Vec3d step_a = a.step();
  const Vec3d step_b = b.step();
  const double yaw = std::atan2(step_a.y(), step_a.x()) - std::atan2(step_b.y(), step_b.x());
  Pose a_from_b = Pose::Identity();
  a_from_b.linear() = Eigen::AngleAxisd(yaw, Vec3d::UnitZ()).toRotationMatrix();
  a_from_b.translation() = (a.from + a.to) / 2 - a_from_b.linear() * ((b.from + b.to) / 2);
  return a_from_b;
}

// Votes for poses that are alike: the turn, and where the middle of b comes to lie.
class PoseVotes {
 public:
  explicit PoseVotes(Vec3d middle_of_b) : middle_of_b_(std::move(middle_of_b)) {}

  void add(const Pose& pose) {
    const double yaw = std::atan2(pose.linear()(1, 0), pose.linear()(0, 0));
    const Vec3d middle = pose * middle_of_b_;
    Bin& bin = bins_[{cell(yaw / kYaw), cell(middle.x() / kShift_m), cell(middle.y() / kShift_m), cell(middle.z() / kShift_m)}];
    bin.count += 1;
    bin.turn += Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    bin.middle += middle;
  }

  std::vector<Pose> most_frequent(std::size_t most) const {
    std::vector<const Bin*> order;
    for (const auto& [key, bin] : bins_) order.push_back(&bin);
    std::stable_sort(order.begin(), order.end(), [](const Bin* x, const Bin* y) { return x->count > y->count; });
    order.resize(std::min(order.size(), most));
    std::vector<Pose> poses;
    for (const Bin* bin : order) {
      Pose pose = Pose::Identity();
      pose.linear() = Eigen::AngleAxisd(std::atan2(bin->turn.y(), bin->turn.x()), Vec3d::UnitZ()).toRotationMatrix();
      pose.translation() = bin->middle / bin->count - pose.linear() * middle_of_b_;
      poses.push_back(pose);
    }
    return poses;
  }

 private:
  static constexpr double kYaw = std::numbers::pi / 12;
  static constexpr double kShift_m = 0.6;

  struct Bin {
    int count = 0;
    Eigen::Vector2d turn = Eigen::Vector2d::Zero();
    Vec3d middle = Vec3d::Zero();
  };
  static int cell(double value) { return static_cast<int>(std::floor(value)); }

  Vec3d middle_of_b_;
  std::map<std::array<int, 4>, Bin> bins_;
};

// The equations of one step: motions of b about `middle`, which are (turn, shift).
struct FitEquations {
  Matrix6d normal = Matrix6d::Zero();
  Vec6d right = Vec6d::Zero();
  double weight = 0;
};

// Far pairs count less (Tukey's weights). Turns are measured by what they move at the radius of b, so that they compare with
// shifts.
FitEquations equations_of(const FitTarget& a, double fit_radius_m, const std::vector<PlacedNormal>& moved, const Vec3d& middle,
                          double radius_m) {
  FitEquations sum;
  for (const PlacedNormal& p : moved) {
    const PlacedNormal* q = a.find(p, fit_radius_m);
    if (q == nullptr) continue;
    const double off = q->normal.dot(q->at - p.at);
    const double share = (q->at - p.at).norm() / fit_radius_m;
    const double weight = (1 - share * share) * (1 - share * share);
    Vec6d row;
    row << (p.at - middle).cross(q->normal) / radius_m, q->normal;
    sum.normal += weight * row * row.transpose();
    sum.right += weight * off * row;
    sum.weight += weight;
  }
  return sum;
}

std::vector<Vec3f> places_of(const std::vector<PlacedNormal>& points) {
  std::vector<Vec3f> places;
  places.reserve(points.size());
  for (const PlacedNormal& p : points) places.emplace_back(p.at.cast<float>());
  return places;
}

std::vector<PlacedNormal> moved_points(const std::vector<PlacedNormal>& points, const Pose& pose) {
  std::vector<PlacedNormal> moved;
  moved.reserve(points.size());
  for (const PlacedNormal& p : points) moved.push_back({pose * p.at, pose.linear() * p.normal});
  return moved;
}

}  // namespace

std::vector<Pose> poses_by_constellations(const std::vector<Landmark>& a, const std::vector<Landmark>& b, std::size_t most) {
  if (a.empty() || b.empty()) return {};
  Vec3d middle = Vec3d::Zero();
  for (const Landmark& landmark : b) middle += landmark.at / static_cast<double>(b.size());
  PoseVotes votes(middle);
  const auto pairs_a = pairs_of(a);
  for (const auto& [classes, list_b] : pairs_of(b)) {
    const auto list_a = pairs_a.find(classes);
    if (list_a == pairs_a.end()) continue;
    for (const LandmarkPair& pair_b : list_b) {
      const auto shorter = [](const LandmarkPair& pair, double length_m) { return pair.length_m() < length_m; };
      auto at = std::lower_bound(list_a->second.begin(), list_a->second.end(), pair_b.length_m() - kCenterError_m, shorter);
      for (; at != list_a->second.end() && at->length_m() <= pair_b.length_m() + kCenterError_m; ++at) {
        if (std::abs(at->step().z() - pair_b.step().z()) <= kCenterError_m) votes.add(pose_between(*at, pair_b));
      }
    }
  }
  return votes.most_frequent(most);
}

FitTarget::FitTarget(std::vector<PlacedNormal> points) : points_(std::move(points)), nearest_(places_of(points_)) {}

const PlacedNormal* FitTarget::find(const PlacedNormal& point, double radius_m) const {
  constexpr double kAlike = 0.5;
  const auto found = nearest_.nearest(point.at.cast<float>());
  if (!found || !(found->distance_m < radius_m)) return nullptr;
  const PlacedNormal& near = points_[found->index];
  return near.normal.dot(point.normal) > kAlike ? &near : nullptr;
}

SurfaceFit fitted(const FitTarget& a, double fit_radius_m, const std::vector<PlacedNormal>& b, const Pose& start, int steps) {
  SurfaceFit fit{start, 0};
  if (b.empty()) return fit;
  for (int step = 0; step < steps; ++step) {
    const std::vector<PlacedNormal> moved = moved_points(b, fit.a_from_b);
    Vec3d middle = Vec3d::Zero();
    for (const PlacedNormal& p : moved) middle += p.at / static_cast<double>(moved.size());
    double square_m2 = 0;
    for (const PlacedNormal& p : moved) square_m2 += (p.at - middle).squaredNorm() / static_cast<double>(moved.size());
    const double radius_m = std::max(std::sqrt(square_m2), 1e-3);
    const FitEquations sum = equations_of(a, fit_radius_m, moved, middle, radius_m);
    if (!(sum.weight > 0)) return {fit.a_from_b, 0};
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(sum.normal / sum.weight);
    fit.least_hold = std::max(solver.eigenvalues()[0], 0.0);
    constexpr double kDamping = 1e-3;  // a direction that nothing holds stays as it is
    const Vec6d motion = (sum.normal + kDamping * sum.weight * Matrix6d::Identity()).ldlt().solve(sum.right);
    const Vec3d turn = motion.head<3>() / radius_m;
    Pose step_pose = Pose::Identity();
    if (turn.norm() > 0) step_pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    step_pose.translation() = middle + motion.tail<3>() - step_pose.linear() * middle;
    fit.a_from_b = step_pose * fit.a_from_b;
  }
  return fit;
}

}  // namespace panoptic
