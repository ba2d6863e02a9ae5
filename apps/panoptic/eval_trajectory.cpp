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

double share(std::size_t part, std::size_t whole) { return static_cast<double>(part) / static_cast<double>(whole); }

Json to_json(const ErrorStatistics& s) {
  if (s.count == 0) return nullptr;
  return {{"count", s.count}, {"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.standard_deviation},
          {"min", s.least},   {"max", s.most}};
}

Json to_json(const TrajectoryScores& s) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> m = s.truth_from_estimate.matrix();
  return {{"poses", s.poses},
          {"true_poses", s.true_poses},
          {"pairs", s.absolute_m.count},
          {"share_of_estimate", share(s.absolute_m.count, s.poses)},
          {"share_of_truth", share(s.absolute_m.count, s.true_poses)},
          {"way_m", s.way_m},
          {"ate_m", to_json(s.absolute_m)},
          {"rpe_m", to_json(s.relative_m)},
          {"rpe_deg", to_json(s.relative_deg)},
          {"truth_from_estimate", std::vector<double>(m.data(), m.data() + m.size())}};
}

void print_line(const std::string& name, const ErrorStatistics& s, double scale, const char* unit) {
  if (s.count == 0) {
    fmt::print("{:<14}{:>8}{:>10}  no two poses are that far apart\n", name, 0, "-");
    return;
  }
  fmt::print("{:<14}{:>8}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}  {}\n", name, s.count, scale * s.rmse, scale * s.mean,
             scale * s.median, scale * s.most, unit);
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
  fmt::print("{} pairs: {:.1f} % of the {} estimated poses, {:.1f} % of the {} true ones; way {:.2f} m\n\n",
             scores.absolute_m.count, 100 * share(scores.absolute_m.count, scores.poses), scores.poses,
             100 * share(scores.absolute_m.count, scores.true_poses), scores.true_poses, scores.way_m);
  fmt::print("{:<14}{:>8}{:>10}{:>10}{:>10}{:>10}\n", "", "count", "rmse", "mean", "median", "max");
  print_line("ATE", scores.absolute_m, 100, "cm");
  const std::string step = fmt::format("{:g} s", a.rpe_step_s);
  print_line(fmt::format("RPE {}", step), scores.relative_m, 100, "cm");
  print_line(fmt::format("RPE {}", step), scores.relative_deg, 1, "degrees");
  if (!a.json.empty()) write_json_file(a.json, to_json(scores));
  return kDone;
}

}  // namespace panoptic
