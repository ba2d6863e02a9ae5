// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/frame_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

#include "panoptic/tracking/alignment_terms.h"

namespace panoptic {
namespace {

using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Vector8d = Eigen::Matrix<double, 8, 1>;

// One pass of the alignment, the coarse first.
struct Pass {
  int across;             // readings along a row of the depth image
  std::size_t from_last;  // level of the pyramid, counted from its coarsest
  float wide_m;           // distances from the surface that still count
  int steps;
};
constexpr std::array<Pass, kGreyLevels> kPasses = {{{40, 0, 0.05F, 6}, {80, 1, 0.02F, 4}, {kReadingsAcross, 2, 0.0F, 3}}};

// A camera that neither surface nor brightness holds is taken to move as it did: as if that were known to this.
constexpr double kPriorDistance_m = 0.01;
constexpr double kPriorAngle_rad = 0.01;
// The readings of a frame share the errors of map and sensor: all together are worth this many independent ones.
constexpr double kIndependent = 100;
constexpr double kPriorGain = 0.2;
constexpr double kPriorOffset = 20;
// The normals of a plane are off by some degrees, so that even where nothing holds the camera they seem to, by the square of
// that.
constexpr double kNormalNoise = 0.003;
constexpr double kConvergedDistance_m = 1e-5;

double typical_depth_m(const std::vector<DepthPoint>& points) {
  double sum = 0;
  for (const DepthPoint& p : points) sum += double{p.in_camera.z()};
  return points.empty() ? 1 : sum / static_cast<double>(points.size());
}

// Takes from the sums what noise of the normals alone would give: directions that no surface holds stay free. Rotations count as
// what they move at the typical depth.
void free_unheld(Matrix6d& products, Vector6d& right_side, double weight, double depth_m) {
  Vector6d scale;
  scale << 1, 1, 1, 1 / depth_m, 1 / depth_m, 1 / depth_m;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(scale.asDiagonal() * products * scale.asDiagonal());
  Vector6d share;
  for (int i = 0; i < share.size(); ++i) {
    const double value = solver.eigenvalues()[i];
    share[i] = value > 0 ? std::max(0.0, 1 - kNormalNoise * weight / value) : 0;
  }
  const Matrix6d kept = solver.eigenvectors() * share.asDiagonal() * solver.eigenvectors().transpose();
  const Vector6d unscale = scale.cwiseInverse();
  const Matrix6d filter = unscale.asDiagonal() * kept * scale.asDiagonal();
  products = filter * products;
  products = 0.5 * (products + products.transpose()).eval();
  right_side = filter * right_side;
}

struct State {
  Pose pose;
  Exposure exposure;
};

// Adds the camera's own motion to the sums.
void add_prior(Matrix8d& products, Vector8d& right_side, const Vector6d& off, const Exposure& exposure) {
  const auto add = [&](int i, double value, double sigma) {
    products(i, i) += 1 / (sigma * sigma);
    right_side[i] += value / (sigma * sigma);
  };
  for (int i = 0; i < 3; ++i) add(i, off[i], kPriorDistance_m);
  for (int i = 3; i < 6; ++i) add(i, off[i], kPriorAngle_rad);
  add(6, exposure.gain, kPriorGain);
  add(7, exposure.offset, kPriorOffset);
}

struct Step {
  Vector8d motion = Vector8d::Zero();
  Matrix6d information = Matrix6d::Zero();
};

Step step_from(const SurfaceSums& surface, const GreySums& grey, const Vector6d& off, const Exposure& exposure, double depth_m) {
  Matrix6d products = surface.sums.matrix();
  Vector6d right_side = surface.sums.right_side();
  free_unheld(products, right_side, surface.sums.weight, depth_m);
  Matrix8d all = grey.sums.matrix();
  Vector8d right = grey.sums.right_side();
  all.topLeftCorner<6, 6>() += products;
  right.head<6>() += right_side;
  const double worth = kIndependent / static_cast<double>(std::max<std::size_t>({surface.sums.count, grey.sums.count, 1}));
  all *= worth;
  right *= worth;
  add_prior(all, right, off, exposure);
  return {-all.ldlt().solve(right), all.topLeftCorner<6, 6>()};
}

std::size_t level_of(const Pass& pass, std::size_t levels) { return levels - 1 - std::min(pass.from_last, levels - 1); }

void judge(Alignment& alignment, std::size_t readings, const SurfaceSums& surface, const GreySums& grey) {
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
  };
  alignment.readings = readings;
  alignment.surface_share = share(surface.sums.count, readings);
  alignment.agreeing_share = share(surface.agreeing, surface.sums.count);
  alignment.grey_points = grey.sums.count;
  alignment.grey_correlation = grey.correlation();
}

}  // namespace

int stride_for(const Frame& frame, int readings_across) { return std::max(1, frame.depth.width() / readings_across); }

Alignment align(const AlignmentTask& task, const Pose& start) {
  State state{start, {}};
  Alignment alignment;
  const bool compares =
      task.reference != nullptr && !task.pyramid.empty() && task.reference->levels.size() == task.pyramid.size();
  for (const Pass& pass : kPasses) {
    const std::vector<DepthPoint> points = smooth_points(task.frame, task.range, stride_for(task.frame, pass.across));
    const double depth_m = typical_depth_m(points);
    const int looks = &pass == &kPasses.back() ? pass.steps + 1 : pass.steps;  // the last of all only judges
    for (int n = 0; n < looks; ++n) {
      const SurfaceSums surface = surface_terms(points, task.map, state.pose, pass.wide_m);
      const GreySums grey =
          compares ? grey_terms(task, level_of(pass, task.pyramid.size()), state.pose, state.exposure) : GreySums();
      const Step step = step_from(surface, grey, motion_of(start.inverse() * state.pose), state.exposure, depth_m);
      judge(alignment, points.size(), surface, grey);
      alignment.covariance = step.information.inverse();
      if (n == pass.steps) break;
      state.pose = state.pose * moved_by(step.motion.head<6>());
      state.exposure.gain += step.motion[6];
      state.exposure.offset += step.motion[7];
      if (step.motion.head<3>().norm() + depth_m * step.motion.segment<3>(3).norm() < kConvergedDistance_m) break;
    }
  }
  const std::size_t all = task.reference == nullptr || task.reference->levels.empty() ? 0 : task.reference->levels.front().size();
  if (all > 0) alignment.grey_share = static_cast<double>(alignment.grey_points) / static_cast<double>(all);
  state.pose.linear() = Eigen::Quaterniond(state.pose.linear()).normalized().toRotationMatrix();
  alignment.world_from_camera = state.pose;
  return alignment;
}

}  // namespace panoptic
