// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "apps/panoptic/commands.h"
#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/trajectory.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

// The file, or the usual one in a folder.
fs::path trajectory_file(const std::string& path) {
  if (!is_folder(path)) return path;
  for (const char* name : {"trajectory.txt", "groundtruth.txt"}) {
    if (is_there(fs::path(path) / name)) return fs::path(path) / name;
  }
  throw Error(fmt::format("{}: holds neither trajectory.txt nor groundtruth.txt; name the file", path));
}

Json to_json(const ErrorStatistics& s) {
  return {{"count", s.count}, {"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.standard_deviation},
          {"min", s.least},   {"max", s.most}};
}

Json to_json(const TrajectoryScores& s, double tracked_share) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> m = s.truth_from_estimate.matrix();
  return {{"poses", s.poses},
          {"true_poses", s.true_poses},
          {"tracked_share", tracked_share},
          {"way_m", s.way_m},
          {"ate_m", to_json(s.absolute_m)},
          {"rpe_m", to_json(s.relative_m)},
          {"rpe_deg", to_json(s.relative_deg)},
          {"truth_from_estimate", std::vector<double>(m.data(), m.data() + m.size())}};
}

void print_line(const char* name, const ErrorStatistics& s, double scale, const char* unit) {
  fmt::print("{:<14}{:>8}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}  {}\n", name, s.count, scale * s.rmse, scale * s.mean,
             scale * s.median, scale * s.most, unit);
}

// The share of the true poses, within the time of the estimate's recording, that have an estimated one.
double tracked_share(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth, const TrajectoryScores& s) {
  return truth.size() <= estimate.size() ? static_cast<double>(s.absolute_m.count) / static_cast<double>(truth.size())
                                         : static_cast<double>(s.absolute_m.count) / static_cast<double>(estimate.size());
}

}  // namespace

int evaluate_trajectory(const Arguments& a) {
  const fs::path estimate_file = trajectory_file(a.trajectory);
  const fs::path truth_file = trajectory_file(a.true_trajectory);
  const std::vector<StampedPose> estimate = read_trajectory(estimate_file);
  const std::vector<StampedPose> truth = read_trajectory(truth_file);
  TrajectoryScores scores;
  try {
    scores = score_trajectory(estimate, truth, {.most_apart_s = a.pair_tolerance_s.value_or(0.02), .step_s = a.rpe_step_s});
  } catch (const Error& e) {
    throw Error(fmt::format("{} against {}: {}", estimate_file.string(), truth_file.string(), e.what()));
  }
  const double share = tracked_share(estimate, truth, scores);
  fmt::print("{} poses, {} true ones, {} pairs ({:.1f} %), way {:.2f} m\n\n", scores.poses, scores.true_poses,
             scores.absolute_m.count, 100 * share, scores.way_m);
  fmt::print("{:<14}{:>8}{:>10}{:>10}{:>10}{:>10}\n", "", "count", "rmse", "mean", "median", "max");
  print_line("ATE", scores.absolute_m, 100, "cm");
  const std::string step = fmt::format("{:g} s", a.rpe_step_s);
  print_line(fmt::format("RPE {}", step).c_str(), scores.relative_m, 100, "cm");
  print_line(fmt::format("RPE {}", step).c_str(), scores.relative_deg, 1, "degrees");
  if (!a.json.empty()) write_json_file(a.json, to_json(scores, share));
  return kDone;
}

}  // namespace panoptic
