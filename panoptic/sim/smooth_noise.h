// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Chance that is alike in neighbouring places: errors of networks come in patches, not as salt and pepper.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "panoptic/geometry.h"
#include "panoptic/sim/random.h"

namespace panoptic {

// Nearly standard normal: four uniform numbers of 16 bits, added.
constexpr double nearly_normal(std::uint64_t bits) {
  constexpr double kRoot3 = 1.7320508075688772;
  constexpr double kMean = 2 * 65535.0;
  const std::uint64_t sum = (bits & 0xffffU) + (bits >> 16U & 0xffffU) + (bits >> 32U & 0xffffU) + (bits >> 48U);
  return (static_cast<double>(sum) - kMean) / 65536.0 * kRoot3;
}

// The share of standard normal values below z.
inline double share_below(double z) {
  constexpr double kRootHalf = 0.7071067811865476;
  return 0.5 * std::erfc(-z * kRootHalf);
}

// Its inverse, to 1e-9; -40 and 40 stand for the infinities.
inline double normal_quantile(double share) {
  double low = -40;
  double high = 40;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (share_below(middle) < share ? low : high) = middle;
  }
  return share <= 0 ? -40 : (share >= 1 ? 40 : high);
}

// Nearly standard normal at every point, smooth, with independent values more than two units apart.
inline double smooth_noise(std::uint64_t seed, const Vec3d& point) {
  std::array<std::array<double, 2>, 3> weight{};
  std::array<std::int64_t, 3> cell{};
  for (int axis = 0; axis < 3; ++axis) {
    const double floor = std::floor(point[axis]);
    const double t = point[axis] - floor;
    cell[axis] = static_cast<std::int64_t>(floor);
    weight[axis][1] = t * t * (3 - 2 * t);
    weight[axis][0] = 1 - weight[axis][1];
  }
  double sum = 0;
  double squares = 0;  // of the weights: dividing by their root keeps the variance at 1 between lattice points too
  for (unsigned corner = 0; corner < 8; ++corner) {
    const unsigned x = corner & 1U;
    const unsigned y = corner >> 1U & 1U;
    const unsigned z = corner >> 2U;
    const double w = weight[0][x] * weight[1][y] * weight[2][z];
    const auto place = mix_bits(static_cast<std::uint64_t>(cell[0] + x) * 0x8da6b343U ^
                                static_cast<std::uint64_t>(cell[1] + y) * 0xd8163841cb1ab3U ^
                                static_cast<std::uint64_t>(cell[2] + z) * 0x9e3779b97f4a7c15U);
    sum += w * nearly_normal(mix_bits(seed ^ place));
    squares += w * w;
  }
  return sum / std::sqrt(squares);
}

}  // namespace panoptic
