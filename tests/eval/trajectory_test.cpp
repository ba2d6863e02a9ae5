// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/trajectory.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using Poses = std::vector<StampedPose>;

// A walk with noise; stamps of the estimate are off by some milliseconds, and some poses are missing.
struct Walk {
  Poses estimate;
  Poses truth;
};

Pose pose_of(const Vec3d& position, const Vec3d& turn) {
  Pose pose = Pose::Identity();
  pose.translation() = position;
  pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  return pose;
}

Walk walk() {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.01);
  const auto shaken = [&] { return Vec3d(noise(random), noise(random), noise(random)); };
  const Pose elsewhere = pose_of({1, 2, 3}, {0.4, -0.2, 0.9});
  Walk result;
  for (int i = 0; i < 120; ++i) {
    const double t = 0.033 * i;
    const Pose pose = pose_of({std::sin(t), 0.5 * t, std::cos(0.7 * t)}, {0.1 + 0.2 * t, 0.3 * std::sin(t), 0.1});
    result.truth.push_back({t, pose});
    if (i % 7 != 3)
      result.estimate.push_back(
          {t + 0.004 * std::sin(3.0 * i), elsewhere * pose * pose_of(shaken(), shaken() + Vec3d(1e-6, 0, 0))});
  }
  return result;
}

std::size_t naive_closest(const Poses& poses, double t) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if (std::abs(poses[i].time_s - t) < std::abs(poses[best].time_s - t)) best = i;
  }
  return best;
}

// associate.py: again and again the two that are closest in time and have no partner.
std::vector<std::pair<std::size_t, std::size_t>> naive_pairs(const Poses& estimate, const Poses& truth, double most_s) {
  std::vector<bool> e_used(estimate.size());
  std::vector<bool> t_used(truth.size());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (;;) {
    double best = most_s;
    std::pair<std::size_t, std::size_t> pair{estimate.size(), 0};
    for (std::size_t e = 0; e < estimate.size(); ++e) {
      for (std::size_t t = 0; t < truth.size(); ++t) {
        const double apart = std::abs(estimate[e].time_s - truth[t].time_s);
        if (!e_used[e] && !t_used[t] && apart < best) {
          best = apart;
          pair = {e, t};
        }
      }
    }
    if (pair.first == estimate.size()) return pairs;
    e_used[pair.first] = t_used[pair.second] = true;
    pairs.push_back(pair);
  }
}

// Horn's alignment by a singular value decomposition, and the root of the mean square of what is left.
double naive_ate(const Walk& w, double most_s) {
  const auto pairs = naive_pairs(w.estimate, w.truth, most_s);
  Vec3d from = Vec3d::Zero();
  Vec3d to = Vec3d::Zero();
  for (const auto& [e, t] : pairs) {
    from += w.estimate[e].world_from_camera.translation();
    to += w.truth[t].world_from_camera.translation();
  }
  from /= static_cast<double>(pairs.size());
  to /= static_cast<double>(pairs.size());
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& [e, t] : pairs) {
    sum += (w.truth[t].world_from_camera.translation() - to) * (w.estimate[e].world_from_camera.translation() - from).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d sign = Eigen::Matrix3d::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) sign(2, 2) = -1;
  const Eigen::Matrix3d rotation = svd.matrixU() * sign * svd.matrixV().transpose();
  double squares = 0;
  for (const auto& [e, t] : pairs) {
    squares +=
        (rotation * (w.estimate[e].world_from_camera.translation() - from) - (w.truth[t].world_from_camera.translation() - to))
            .squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(pairs.size()));
}

double naive_rpe(const Walk& w, double step_s) {
  double squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < w.estimate.size(); ++i) {
    const std::size_t j = naive_closest(w.estimate, w.estimate[i].time_s + step_s);
    if (j + 1 == w.estimate.size()) continue;
    const Pose& a = w.truth[naive_closest(w.truth, w.estimate[i].time_s)].world_from_camera;
    const Pose& b = w.truth[naive_closest(w.truth, w.estimate[j].time_s)].world_from_camera;
    // Rotation and translation of the two motions, written out.
    const Pose& c = w.estimate[i].world_from_camera;
    const Pose& d = w.estimate[j].world_from_camera;
    const Vec3d moved = c.linear().transpose() * (d.translation() - c.translation());
    const Vec3d truly_moved = a.linear().transpose() * (b.translation() - a.translation());
    squares += ((a.linear().transpose() * b.linear()).transpose() * (moved - truly_moved)).squaredNorm();
    ++count;
  }
  return std::sqrt(squares / count);
}

TEST(Trajectory, ScoresAgreeWithTheDefinitions) {
  const Walk w = walk();
  for (const double step_s : {0.5, 1.0}) {
    const TrajectoryScores scores = score_trajectory(w.estimate, w.truth, {.most_apart_s = 0.02, .step_s = step_s});
    EXPECT_NEAR(scores.absolute_m.rmse, naive_ate(w, 0.02), 1e-9);
    EXPECT_NEAR(scores.relative_m.rmse, naive_rpe(w, step_s), 1e-9);
    EXPECT_EQ(scores.absolute_m.count, w.estimate.size());
    EXPECT_GT(scores.relative_deg.rmse, 0.5);
  }
}

TEST(Trajectory, StatisticsAreThoseOfTheErrors) {
  // Two squares around one middle, of which the estimate is a tenth too large: no rigid motion makes that better.
  Poses truth;
  Poses estimate;
  for (int i = 0; i < 8; ++i) {
    const double radius = i < 4 ? 1 : 2;
    const double a = i * std::numbers::pi / 2;
    const Vec3d at(radius * std::cos(a), radius * std::sin(a), 0);
    truth.push_back({0.1 * i, pose_of(at, {0, 0, 1e-9})});
    estimate.push_back({0.1 * i, pose_of(1.1 * at, {0, 0, 1e-9})});
  }
  const ErrorStatistics errors = score_trajectory(estimate, truth).absolute_m;
  EXPECT_EQ(errors.count, 8U);
  EXPECT_NEAR(errors.least, 0.1, 1e-9);
  EXPECT_NEAR(errors.most, 0.2, 1e-9);
  EXPECT_NEAR(errors.mean, 0.15, 1e-9);
  EXPECT_NEAR(errors.median, 0.15, 1e-9);
  EXPECT_NEAR(errors.standard_deviation, 0.05, 1e-9);
  EXPECT_NEAR(errors.rmse, std::sqrt(0.025), 1e-9);
}

TEST(Trajectory, WithoutPartnersThereAreNoScores) {
  Walk w = walk();
  for (StampedPose& pose : w.estimate) pose.time_s += 1000;
  EXPECT_THROW(score_trajectory(w.estimate, w.truth), Error);
  EXPECT_THROW(score_trajectory({}, w.truth), Error);
}

TEST(Trajectory, ABadLineIsNamed) {
  const auto folder = test::fresh_folder("trajectory");
  for (const char* line : {"0 1 2 3 0 0 0", "0 1 2 3 0 0 0 x", "0 1 2 nan 0 0 0 1", "0 1 2 3 0 0 0 0"}) {
    write_file(folder / "bad.txt", std::string("# comment\n0 0 0 0 0 0 0 1\n") + line + "\n");
    try {
      read_trajectory(folder / "bad.txt");
      FAIL() << line;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("bad.txt:3"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(read_trajectory(folder / "absent.txt"), Error);
}

}  // namespace
}  // namespace panoptic
