// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/pose_graph.h"

#include <ceres/ceres.h>

#include <algorithm>

namespace panoptic {
namespace {

struct Node {
  Eigen::Quaterniond rotation;
  Vec3d position;
};

// How far two poses are from standing to one another as measured, in standard deviations.
struct EdgeError {
  const PoseEdge& edge;

  template <typename T>
  bool operator()(const T* rotation_a, const T* position_a, const T* rotation_b, const T* position_b, T* residuals) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> qa(rotation_a);
    const Eigen::Map<const Eigen::Quaternion<T>> qb(rotation_b);
    const Eigen::Map<const Vector> pa(position_a);
    const Eigen::Map<const Vector> pb(position_b);
    const Eigen::Quaternion<T> measured(Eigen::Quaterniond(edge.a_from_b.linear()).cast<T>());
    const Eigen::Quaternion<T> turn = (qa.conjugate() * qb) * measured.conjugate();
    const Vector shift = qa.conjugate() * (pb - pa) - edge.a_from_b.translation().cast<T>();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r.template head<3>() = shift / T(edge.distance_noise_m);
    r.template tail<3>() = T(2) * turn.vec() / T(edge.angle_noise_rad) * (turn.w() < T(0) ? T(-1) : T(1));
    return true;
  }
};

}  // namespace

std::vector<Pose> optimized(std::vector<Pose> poses, const std::vector<PoseEdge>& edges, std::size_t fixed) {
  if (poses.size() < 2 || edges.empty()) return poses;
  std::vector<Node> nodes;
  for (const Pose& pose : poses) nodes.push_back({Eigen::Quaterniond(pose.linear()), pose.translation()});
  ceres::Problem problem;
  for (Node& node : nodes) {
    problem.AddParameterBlock(node.rotation.coeffs().data(), 4, new ceres::EigenQuaternionManifold);
    problem.AddParameterBlock(node.position.data(), 3);
  }
  for (const PoseEdge& edge : edges) {
    Node& a = nodes[edge.a];
    Node& b = nodes[edge.b];
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<EdgeError, 6, 4, 3, 4, 3>(new EdgeError{edge}),
                             edge.may_be_wrong ? new ceres::CauchyLoss(3) : nullptr, a.rotation.coeffs().data(),
                             a.position.data(), b.rotation.coeffs().data(), b.position.data());
  }
  for (std::size_t i = 0; i < std::min(fixed, nodes.size()); ++i) {
    problem.SetParameterBlockConstant(nodes[i].rotation.coeffs().data());
    problem.SetParameterBlockConstant(nodes[i].position.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.max_num_iterations = 50;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return poses;
  for (std::size_t i = fixed; i < poses.size(); ++i) {
    poses[i].linear() = nodes[i].rotation.normalized().toRotationMatrix();
    poses[i].translation() = nodes[i].position;
  }
  return poses;
}

}  // namespace panoptic
