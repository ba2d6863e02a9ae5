// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_text.h"

namespace panoptic {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

struct Pair {
  std::size_t estimate = 0;
  std::size_t truth = 0;
  double apart_s = 0;
};

// All pairs of stamps that are close enough, in the order of the estimate.
std::vector<Pair> close_pairs(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth, double most_s) {
  std::vector<Pair> pairs;
  std::size_t begin = 0;
  for (std::size_t e = 0; e < estimate.size(); ++e) {
    const double time_s = estimate[e].time_s;
    while (begin < truth.size() && truth[begin].time_s < time_s - most_s) ++begin;
    for (std::size_t t = begin; t < truth.size() && truth[t].time_s < time_s + most_s; ++t) {
      const double apart_s = std::abs(truth[t].time_s - time_s);
      if (apart_s < most_s) pairs.push_back({e, t, apart_s});
    }
  }
  return pairs;
}

std::vector<Pair> associated(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth, double most_s) {
  std::vector<Pair> candidates = close_pairs(estimate, truth, most_s);
  std::stable_sort(candidates.begin(), candidates.end(), [](const Pair& a, const Pair& b) { return a.apart_s < b.apart_s; });
  std::vector<bool> estimate_used(estimate.size());
  std::vector<bool> truth_used(truth.size());
  std::vector<Pair> pairs;
  for (const Pair& pair : candidates) {
    if (estimate_used[pair.estimate] || truth_used[pair.truth]) continue;
    estimate_used[pair.estimate] = truth_used[pair.truth] = true;
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.truth < b.truth; });
  return pairs;
}

ErrorStatistics statistics(std::vector<double> errors) {
  ErrorStatistics s;
  if (errors.empty()) return s;
  std::sort(errors.begin(), errors.end());
  const auto n = static_cast<double>(errors.size());
  s.count = errors.size();
  s.mean = std::accumulate(errors.begin(), errors.end(), 0.0) / n;
  const double squares = std::accumulate(errors.begin(), errors.end(), 0.0, [](double sum, double e) { return sum + e * e; });
  s.rmse = std::sqrt(squares / n);
  const double spread =
      std::accumulate(errors.begin(), errors.end(), 0.0, [&](double sum, double e) { return sum + (e - s.mean) * (e - s.mean); });
  s.standard_deviation = std::sqrt(spread / n);
  const std::size_t middle = errors.size() / 2;
  s.median = errors.size() % 2 == 1 ? errors[middle] : (errors[middle - 1] + errors[middle]) / 2;
  s.least = errors.front();
  s.most = errors.back();
  return s;
}

Pose fitted(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth, const std::vector<Pair>& pairs) {
  Eigen::Matrix3Xd from(3, pairs.size());
  Eigen::Matrix3Xd to(3, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = estimate[pairs[i].estimate].world_from_camera.translation();
    to.col(static_cast<Eigen::Index>(i)) = truth[pairs[i].truth].world_from_camera.translation();
  }
  return Pose(Eigen::umeyama(from, to, false));
}

// The pose nearest in time. REQUIRES that there is one.
std::size_t closest(const std::vector<StampedPose>& poses, double time_s) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), time_s, [](const StampedPose& p, double t) { return p.time_s < t; });
  if (after == poses.begin()) return 0;
  const auto before = std::prev(after);
  const bool is_before = after == poses.end() || time_s - before->time_s <= after->time_s - time_s;
  return static_cast<std::size_t>((is_before ? before : after) - poses.begin());
}

double median_gap_s(const std::vector<StampedPose>& poses) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < poses.size(); ++i) gaps.push_back(poses[i].time_s - poses[i - 1].time_s);
  return statistics(std::move(gaps)).median;
}

void score_relative(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth, double step_s,
                    TrajectoryScores& scores) {
  const double most_apart_s = 2 * median_gap_s(truth);
  std::vector<double> distances;
  std::vector<double> angles;
  const auto partner = [&](std::size_t e) { return closest(truth, estimate[e].time_s); };
  const auto is_near = [&](std::size_t e) { return std::abs(truth[partner(e)].time_s - estimate[e].time_s) <= most_apart_s; };
  const auto step = [](const std::vector<StampedPose>& poses, std::size_t a, std::size_t b) {
    return Pose(poses[a].world_from_camera.inverse() * poses[b].world_from_camera);
  };
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const std::size_t j = closest(estimate, estimate[i].time_s + step_s);
    if (j + 1 == estimate.size() || !is_near(i) || !is_near(j)) continue;
    const Pose error = step(truth, partner(i), partner(j)).inverse() * step(estimate, i, j);
    distances.push_back(error.translation().norm());
    angles.push_back(kDegrees * Eigen::AngleAxisd(error.linear()).angle());
  }
  scores.relative_m = statistics(std::move(distances));
  scores.relative_deg = statistics(std::move(angles));
}

}  // namespace

std::vector<StampedPose> read_trajectory(const std::filesystem::path& path) {
  constexpr std::size_t kColumns = 8;
  std::vector<StampedPose> poses;
  const std::string text = read_file(path);
  for_each_line_of(text, kWordSeparators, [&](std::size_t line, std::span<const std::string_view> words) {
    const std::vector<double> n = to_numbers(words, path, line);
    if (n.size() != kColumns) {
      throw Error(fmt::format("{}:{}: expected 'time tx ty tz qx qy qz qw', found {} numbers", path.string(), line, n.size()));
    }
    const Eigen::Quaterniond rotation(n[7], n[4], n[5], n[6]);
    const bool is_finite = std::all_of(n.begin(), n.end(), [](double x) { return std::isfinite(x); });
    constexpr double kTolerance = 0.05;
    if (!is_finite || std::abs(rotation.norm() - 1) > kTolerance) {
      throw Error(fmt::format("{}:{}: is no pose: position and a quaternion of length 1", path.string(), line));
    }
    StampedPose pose{n[0], Pose::Identity()};
    pose.world_from_camera.linear() = rotation.normalized().toRotationMatrix();
    pose.world_from_camera.translation() = Vec3d(n[1], n[2], n[3]);
    poses.push_back(pose);
  });
  std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) { return a.time_s < b.time_s; });
  return poses;
}

TrajectoryScores score_trajectory(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                                  const TrajectoryOptions& options) {
  constexpr std::size_t kFewest = 3;
  const std::vector<Pair> pairs = associated(estimate, truth, options.most_apart_s);
  if (pairs.size() < kFewest) {
    throw Error(
        fmt::format("{} of {} estimated poses have a true one within {} s, and it takes {}; are the time stamps of one clock?",
                    pairs.size(), estimate.size(), options.most_apart_s, kFewest));
  }
  TrajectoryScores scores;
  scores.poses = estimate.size();
  scores.true_poses = truth.size();
  scores.truth_from_estimate = fitted(estimate, truth, pairs);
  std::vector<double> errors;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vec3d at = truth[pairs[i].truth].world_from_camera.translation();
    errors.push_back((scores.truth_from_estimate * estimate[pairs[i].estimate].world_from_camera.translation() - at).norm());
    if (i > 0) scores.way_m += (at - truth[pairs[i - 1].truth].world_from_camera.translation()).norm();
  }
  scores.absolute_m = statistics(std::move(errors));
  score_relative(estimate, truth, options.step_s, scores);
  return scores;
}

}  // namespace panoptic
