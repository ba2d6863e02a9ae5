// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How far an estimated trajectory is from the true one, as the tools of the TUM RGB-D benchmark measure it (Sturm et al. 2012).
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic {

struct StampedPose {
  double time_s = 0;
  Pose world_from_camera = Pose::Identity();
};

// Reads `time tx ty tz qx qy qz qw` a line; lines that begin with # are left out. In the order of time. Throws Error naming the
// line.
std::vector<StampedPose> read_trajectory(const std::filesystem::path& path);

// Statistics of errors; all zero if there are none.
struct ErrorStatistics {
  std::size_t count = 0;
  double rmse = 0;
  double mean = 0;
  double median = 0;
  double standard_deviation = 0;
  double least = 0;
  double most = 0;
};

struct TrajectoryScores {
  std::size_t poses = 0;  // of the estimate
  std::size_t true_poses = 0;
  double way_m = 0;  // that the true camera went, from the first pair to the last
  // ATE: distances of the pairs after the rigid motion (no scale) that fits the estimate to the truth best (Horn 1987).
  ErrorStatistics absolute_m;
  Pose truth_from_estimate = Pose::Identity();
  // RPE: what the estimate moved too much or too little, and turned, over `step_s`.
  ErrorStatistics relative_m;
  ErrorStatistics relative_deg;
};

struct TrajectoryOptions {
  double most_apart_s = 0.02;  // between the two stamps of a pair
  double step_s = 1;           // of the relative error
};

// Pairs are chosen as associate.py does: those closest in time first, each pose once. The relative error is that of
// evaluate_rpe.py with --fixed_delta. REQUIRES both in the order of time. Throws Error if fewer than three poses have a partner.
TrajectoryScores score_trajectory(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                                  const TrajectoryOptions& options = {});

}  // namespace panoptic
