// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/pose_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "panoptic/data/motion.h"

namespace panoptic {
namespace {

// Cameras on a circle that look along it.
std::vector<Pose> circle(std::size_t count) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    Vector6d motion;
    motion << 3 * std::cos(a) - 3, 3 * std::sin(a), 0, 0, 0, a > std::numbers::pi ? a - 2 * std::numbers::pi : a;
    poses.push_back(moved_by(motion));
  }
  return poses;
}

class PoseGraph : public testing::Test {
 protected:
  PoseGraph() {
    Vector6d drift;
    drift << 0.01, 0.005, 0.004, 0, 0.001, 0.003;
    drifted_.push_back(truth_.front());
    for (std::size_t i = 1; i < truth_.size(); ++i) {
      const Pose step = truth_[i - 1].inverse() * truth_[i] * moved_by(drift);
      edges_.push_back({i - 1, i, step});
      drifted_.push_back(drifted_.back() * step);
    }
  }
  double farthest_off_m(const std::vector<Pose>& poses) const {
    double most = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) most = std::max(most, difference(poses[i], truth_[i]).distance_m);
    return most;
  }

  const std::vector<Pose> truth_ = circle(30);
  std::vector<Pose> drifted_;
  std::vector<PoseEdge> edges_;
};

TEST_F(PoseGraph, WithoutALoopNothingMoves) {
  const std::vector<Pose> same = optimized(drifted_, edges_);
  for (std::size_t i = 0; i < same.size(); ++i) EXPECT_LT(difference(same[i], drifted_[i]).distance_m, 1e-6);
  EXPECT_TRUE(optimized({}, {}).empty());
}

TEST_F(PoseGraph, ALoopTakesTheDriftAway) {
  edges_.push_back({29, 0, truth_[29].inverse() * truth_[0]});
  edges_.back().may_be_wrong = true;
  const std::vector<Pose> corrected = optimized(drifted_, edges_);
  EXPECT_EQ(corrected.front().matrix(), truth_.front().matrix());
  EXPECT_GT(farthest_off_m(drifted_), 0.3);
  EXPECT_LT(farthest_off_m(corrected), 0.5 * farthest_off_m(drifted_));
  EXPECT_LT(difference(corrected.back(), truth_.back()).distance_m, 0.03);
}

TEST_F(PoseGraph, AWrongLoopAmongRightOnesCountsLittle) {
  edges_.push_back({29, 0, truth_[29].inverse() * truth_[0]});
  edges_.push_back({28, 1, truth_[28].inverse() * truth_[1]});
  edges_.push_back({27, 2, truth_[27].inverse() * truth_[2]});
  for (std::size_t i = edges_.size() - 3; i < edges_.size(); ++i) edges_[i].may_be_wrong = true;
  const double right_m = farthest_off_m(optimized(drifted_, edges_));
  edges_.push_back({15, 3, Pose::Identity()});  // three metres off
  edges_.back().may_be_wrong = true;
  EXPECT_LT(farthest_off_m(optimized(drifted_, edges_)), right_m + 0.1);
}

TEST_F(PoseGraph, FixedPosesStayAndTheOthersFollowThem) {
  constexpr std::size_t kFixed = 10;
  std::vector<Pose> poses = drifted_;
  std::copy_n(truth_.begin(), kFixed, poses.begin());
  edges_.push_back({29, 0, truth_[29].inverse() * truth_[0]});
  const std::vector<Pose> corrected = optimized(poses, edges_, kFixed);
  for (std::size_t i = 0; i < kFixed; ++i) EXPECT_EQ(corrected[i].matrix(), truth_[i].matrix());
  EXPECT_LT(difference(corrected.back(), truth_.back()).distance_m, 0.03);
}

}  // namespace
}  // namespace panoptic
