// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Labelled maps without frames: solids given by their signed distance, and voxels strewn at random.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/voxel_map.h"
#include "tests/block_planes.h"

namespace panoptic::test {

constexpr LabelSlot pid(int n) { return static_cast<LabelSlot>(n); }

struct Solid {
  std::function<double(const Vec3d&)> distance_m;  // positive outside
  LabelSlot label = LabelSlot::kUnknown;
};

inline Solid solid_box(const Vec3d& low, const Vec3d& high, LabelSlot label) {
  return {[=](const Vec3d& p) {
            const Vec3d d = (low - p).cwiseMax(p - high);
            return d.cwiseMax(0.0).norm() + std::min(0.0, d.maxCoeff());
          },
          label};
}

// All below the plane of points with up . x = height.
inline Solid solid_ground(const Vec3d& up, double height_m, LabelSlot label) {
  return {[=](const Vec3d& p) { return p.dot(up) - height_m; }, label};
}

// Adds what is within [low, high) to the map: a voxel is observed from the truncation behind the surface outwards and holds the
// label of the nearest solid.
inline void add_solids(VoxelMap& map, const std::vector<Solid>& solids, const Vec3d& low, const Vec3d& high) {
  const auto block_of = [&](double m) { return static_cast<std::int32_t>(std::floor(m / double{map.block_size_m()})); };
  for (std::int32_t bz = block_of(low.z()); bz <= block_of(high.z()); ++bz) {
    for (std::int32_t by = block_of(low.y()); by <= block_of(high.y()); ++by) {
      for (std::int32_t bx = block_of(low.x()); bx <= block_of(high.x()); ++bx) {
        test::BlockEdit block_edit(map.block(map.allocate({bx, by, bz})));
        BlockPlanes& block = *block_edit;
        for (int v = 0; v < kBlockVoxels; ++v) {
          const Vec3d at(bx * kBlockSide + v % kBlockSide, by * kBlockSide + v / kBlockSide % kBlockSide,
                         bz * kBlockSide + v / (kBlockSide * kBlockSide));
          const Vec3d p = (at + Vec3d::Constant(0.5)) * double{map.voxel_size_m()};
          if ((p.array() < low.array()).any() || (p.array() >= high.array()).any()) continue;
          const Solid* nearest = &solids.front();
          for (const Solid& solid : solids) {
            if (solid.distance_m(p) < nearest->distance_m(p)) nearest = &solid;
          }
          const double d = nearest->distance_m(p);
          if (d < -double{map.truncation_m()}) continue;
          const auto i = static_cast<std::size_t>(v);
          block.distance[i] = std::min(static_cast<float>(d), map.truncation_m());
          block.weight[i] = block.label_weight[i] = block.vote_sum[i] = 1;
          block.label[i] = number(nearest->label);
        }
      }
    }
  }
}

// Blocks around the origin, some missing; this share of their voxels at the surface, the others unobserved or far from it.
inline VoxelMap strewn_map(double share, int labels, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto chance = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  VoxelMap map{MapOptions{}};
  for (std::int32_t n = 0; n < 27; ++n) {
    if (chance() < 0.3) continue;
    test::BlockEdit block_edit(map.block(map.allocate({n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1})));
    BlockPlanes& block = *block_edit;
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      const bool at_surface = chance() < share;
      const double voxels = at_surface ? 3 * chance() - 1.5 : 1.6 + chance();
      block.distance[v] = static_cast<float>(voxels) * map.voxel_size_m() * 0.999F;
      block.weight[v] = at_surface || chance() < 0.5 ? 1.0F : 0.0F;
      if (!at_surface && block.weight[v] <= 0) block.distance[v] = 0;  // near, but never observed
      block.label[v] = static_cast<std::uint16_t>(random() % static_cast<std::uint64_t>(labels));
      block.label_weight[v] = block.vote_sum[v] = 2;
    }
  }
  return map;
}

}  // namespace panoptic::test
