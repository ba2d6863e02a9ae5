// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Chance for those who live in a map: numbers that are the same for the same seed, and places of a navigation mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "panoptic/planning/agent_rules.h"
#include "panoptic/planning/recast_mesh.h"

namespace panoptic {

// The same row of numbers everywhere for the same seed (mulberry32, as the page has it).
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : state_(seed) {}

  // At least 0, less than 1.
  double roll() {
    constexpr double kValues = 4294967296.0;
    state_ += 0x6d2b79f5U;
    std::uint32_t t = (state_ ^ (state_ >> 15)) * (1U | state_);
    t = (t + (t ^ (t >> 7)) * (61U | t)) ^ t;
    return static_cast<double>(t ^ (t >> 14)) / kValues;
  }
  double between(const agent_rules::Range& range) { return range.low + (range.high - range.low) * roll(); }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(roll() * static_cast<double>(count)); }

 private:
  std::uint32_t state_;
};

// Places of a mesh, each as likely as any other. REQUIRES a mesh with polygons.
class MeshPlaces {
 public:
  explicit MeshPlaces(const RecastMesh& mesh) : flat_(mesh.triangles()) {
    double sum_m2 = 0;
    for (const auto& corners : flat_.triangles) {
      const Vec3f a = flat_.vertices[corners[1]] - flat_.vertices[corners[0]];
      const Vec3f b = flat_.vertices[corners[2]] - flat_.vertices[corners[0]];
      sums_m2_.push_back(sum_m2 += std::abs(double{a.x()} * double{b.y()} - double{a.y()} * double{b.x()}) / 2);
    }
  }

  Vec3d any(Dice& dice) const {
    const auto at = std::upper_bound(sums_m2_.begin(), sums_m2_.end(), dice.roll() * sums_m2_.back());
    const auto& corners = flat_.triangles[static_cast<std::size_t>(std::min(at, sums_m2_.end() - 1) - sums_m2_.begin())];
    double u = dice.roll();
    double v = dice.roll();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3d a = flat_.vertices[corners[0]].cast<double>();
    return a + u * (flat_.vertices[corners[1]].cast<double>() - a) + v * (flat_.vertices[corners[2]].cast<double>() - a);
  }

 private:
  FlatTriangles flat_;
  std::vector<double> sums_m2_;  // up to each triangle
};

}  // namespace panoptic
