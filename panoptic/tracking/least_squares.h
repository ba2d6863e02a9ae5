// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The normal equations of a robust least-squares problem, summed in a fixed order.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace panoptic {

// Sums of N unknowns: J^T W J, J^T W r, and how well the residuals fit.
template <int N>
struct LeastSquares {
  std::array<double, N*(N + 1) / 2> products{};  // the upper triangle of J^T W J, row by row
  std::array<double, N> gradient{};              // J^T W r
  double weighted_squares = 0;                   // sum of w r^2
  double weight = 0;                             // sum of w
  std::size_t count = 0;

  void add(const std::array<float, N>& jacobian, float residual, float w) {
    std::size_t k = 0;
    for (std::size_t i = 0; i < N; ++i) {
      const float weighted = w * jacobian[i];
      for (std::size_t j = i; j < N; ++j) products[k++] += double{weighted * jacobian[j]};
      gradient[i] += double{weighted * residual};
    }
    weighted_squares += double{w * residual * residual};
    weight += double{w};
    ++count;
  }
  void add(const LeastSquares& other) {
    for (std::size_t k = 0; k < products.size(); ++k) products[k] += other.products[k];
    for (std::size_t i = 0; i < gradient.size(); ++i) gradient[i] += other.gradient[i];
    weighted_squares += other.weighted_squares;
    weight += other.weight;
    count += other.count;
  }
  Eigen::Matrix<double, N, N> matrix() const {
    Eigen::Matrix<double, N, N> m;
    std::size_t k = 0;
    for (int i = 0; i < N; ++i) {
      for (int j = i; j < N; ++j) m(i, j) = m(j, i) = products[k++];
    }
    return m;
  }
  Eigen::Matrix<double, N, 1> right_side() const { return Eigen::Map<const Eigen::Matrix<double, N, 1>>(gradient.data()); }
};

}  // namespace panoptic
