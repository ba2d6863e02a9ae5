// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/support_planes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr double kCell_m = 0.05;

// Before and after a voxel along an axis, within its block.
std::pair<int, int> around(int voxel, int axis) {
  constexpr std::array<int, 3> kSteps = {1, kBlockSide, kBlockSide * kBlockSide};
  const int step = kSteps[static_cast<std::size_t>(axis)];
  const int c = voxel & (step * (kBlockSide - 1));  // the coordinate, times the step; a division here is half of the time
  return {c == 0 ? voxel : voxel - step, c == step * (kBlockSide - 1) ? voxel : voxel + step};
}

bool neighbours_observed(const VoxelBlock& block, std::uint16_t voxel) {
  for (int a = 0; a < 3; ++a) {
    const auto [before, after] = around(voxel, a);
    if (block.weight(before) <= 0 || block.weight(after) <= 0) return false;
  }
  return true;
}

// Right if the neighbours were observed.
Vec3d unchecked_normal(const VoxelBlock& block, std::uint16_t voxel) {
  Vec3d n;
  for (int a = 0; a < 3; ++a) {
    const auto [before, after] = around(voxel, a);
    const bool at_edge = before == voxel || after == voxel;
    n[a] = (double{block.distance(after)} - block.distance(before)) * (at_edge ? 1.0 : 0.5);
  }
  const double length = n.norm();
  return length > 0 ? Vec3d(n / length) : n;
}

int cell_of(double m) { return static_cast<int>(std::floor(m / kCell_m)); }

std::uint64_t cell_key(int east, int north) {
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(east)) << 32 | static_cast<std::uint32_t>(north);
}

// The cells of the points that lie in the top, and those around them: a top is seldom seen without gaps.
void add_footprint(SupportTop& top, std::span<const Vec3d> points, double inlier_m) {
  std::vector<std::pair<int, int>> seen;
  for (const Vec3d& p : points) {
    if (std::abs(top.height_above(p)) > inlier_m) continue;
    const std::pair cell(cell_of(p.dot(top.east)), cell_of(p.dot(top.north)));
    if (seen.empty() || seen.back() != cell) seen.push_back(cell);
  }
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  for (const auto& [east, north] : seen) {
    top.bounds_m.extend(Eigen::Vector2d(east - 2, north - 2) * kCell_m);
    top.bounds_m.extend(Eigen::Vector2d(east + 3, north + 3) * kCell_m);
    for (int n = 0; n < 9; ++n) {
      const int de = n % 3 - 1;
      const int dn = n / 3 - 1;
      top.cells.insert(cell_key(east + de, north + dn));
      top.cells.insert(cell_key(east + 2 * de, north + 2 * dn));
    }
  }
}

Vec3d centre_m(const std::array<std::int32_t, 3>& corner, double voxel_m) {
  return (Vec3d(corner[0], corner[1], corner[2]) + Vec3d::Constant(kBlockSide / 2.0)) * voxel_m;
}

}  // namespace

Vec3d normal_of(const VoxelMap& map, const SurfaceVoxel& p) {
  const VoxelBlock& block = map.block(p.slot);
  return neighbours_observed(block, p.voxel) ? unchecked_normal(block, p.voxel) : Vec3d(Vec3d::Zero());
}

Vec3d place_m(const SurfaceVoxel& p, double voxel_m) {
  return (Vec3d(p.at[0], p.at[1], p.at[2]) + Vec3d::Constant(0.5)) * voxel_m;
}

Vec3d vertical(const VoxelMap& map, const SurfaceVoxels& surface, const Vec3d& up) {
  constexpr double kCosines[] = {0.7, 0.85, 0.95, 0.985, 0.985};
  constexpr std::uint32_t kMostAsked = 200'000;  // a few square metres of floor are enough
  const auto every = std::max<std::uint32_t>(5, static_cast<std::uint32_t>(surface.size()) / kMostAsked);
  std::vector<Vec3d> normals((surface.size() + every - 1) / every);
  parallel_for(surface.block_count(), [&](std::size_t slot) {
    const auto [first, end] = surface.range_of(static_cast<Slot>(slot));
    for (std::uint32_t i = (first + every - 1) / every * every; i < end; i += every) {
      normals[i / every] = unchecked_normal(map.block(static_cast<Slot>(slot)), surface.place_of(i).second);
    }
  });
  // Most normals never come near the direction, and to look at the weights takes as long as the normal.
  std::vector<bool> checked(normals.size(), false);
  const auto check = [&](std::size_t k) {
    const auto [slot, voxel] = surface.place_of(static_cast<std::uint32_t>(k) * every);
    if (!neighbours_observed(map.block(slot), voxel)) normals[k] = Vec3d::Zero();
    checked[k] = true;
  };
  Vec3d direction = up;
  for (const double cosine : kCosines) {
    Vec3d sum = Vec3d::Zero();
    for (std::size_t k = 0; k < normals.size(); ++k) {
      if (!(normals[k].dot(direction) > cosine)) continue;
      if (!checked[k]) check(k);
      sum += normals[k];
    }
    if (sum.norm() > 0) direction = sum.normalized();
  }
  return direction;
}

double SupportTop::height_above(const Vec3d& p) const {
  return p.dot(up) - (height_m + slope_east * p.dot(east) + slope_north * p.dot(north));
}

bool SupportTop::below(const Vec3d& p) const { return cells.contains(cell_key(cell_of(p.dot(east)), cell_of(p.dot(north)))); }

std::optional<SupportTop> fit_top(const VoxelMap& map, const SurfaceVoxels& surface, std::span<const std::uint32_t> points,
                                  const Vec3d& up) {
  constexpr double kBin_m = 0.01;
  constexpr double kNearlyUp = 0.94;  // cosine of 20 degrees
  constexpr double kInlier_m = 0.025;
  if (points.size() < kFewestOfTop) return std::nullopt;
  const double voxel_m = map.voxel_size_m();
  std::map<int, int> bins;
  std::vector<Vec3d> level;
  for (const std::uint32_t i : points) {
    if (normal_of(map, surface[i]).dot(up) < kNearlyUp) continue;
    level.push_back(place_m(surface[i], voxel_m));
    // The voxel's distance leads from its centre to the surface.
    level.back() -= up * double{map.block(surface[i].slot).distance(surface[i].voxel)};
    ++bins[static_cast<int>(std::floor(level.back().dot(up) / kBin_m))];
  }
  if (level.size() < kFewestOfTop) return std::nullopt;
  int peak = 0;
  int most = 0;
  for (const auto& [bin, count] : bins) {
    int sum = 0;
    for (int b = bin - 1; b <= bin + 1; ++b) {
      if (const auto found = bins.find(b); found != bins.end()) sum += found->second;
    }
    if (sum > most) {
      most = sum;
      peak = bin;
    }
  }
  SupportTop top;
  top.up = up;
  top.east = up.unitOrthogonal();
  top.north = up.cross(top.east);
  top.height_m = (peak + 0.5) * kBin_m;
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const Vec3d& p : level) {
      if (std::abs(top.height_above(p)) > kInlier_m) continue;
      const Eigen::Vector3d row(1, p.dot(top.east), p.dot(top.north));
      a += row * row.transpose();
      b += row * p.dot(up);
    }
    if (a(0, 0) < kFewestOfTop) return std::nullopt;
    const Eigen::Vector3d x = a.ldlt().solve(b);
    top.height_m = x[0];
    top.slope_east = x[1];
    top.slope_north = x[2];
  }
  add_footprint(top, level, kInlier_m);
  return top;
}

bool may_be_over(const SupportTop& top, const std::array<std::int32_t, 3>& corner, double voxel_m) {
  const Vec3d centre = centre_m(corner, voxel_m);
  const double radius_m = kBlockSide * voxel_m;  // a little more than half of the diagonal
  return top.bounds_m.squaredExteriorDistance(Eigen::Vector2d(centre.dot(top.east), centre.dot(top.north))) <=
         radius_m * radius_m;
}

bool may_stand_on(const SupportTop& top, const std::array<std::int32_t, 3>& corner, double voxel_m, double height_m) {
  const Vec3d centre = centre_m(corner, voxel_m);
  // How much the height can differ within the block; and two voxels more, as a voxel may stand for a place a little off.
  const Vec3d gradient = top.up - top.slope_east * top.east - top.slope_north * top.north;
  const double slack_m = (gradient.lpNorm<1>() * kBlockSide / 2 + 2) * voxel_m;
  const double height = top.height_above(centre);
  return height + slack_m > height_m && height - slack_m < kHighest_m;
}

bool stands_on(const SupportTop& top, const Vec3d& p, double height_m, bool within_footprint) {
  const double height = top.height_above(p);
  return height > height_m && height < kHighest_m && (!within_footprint || top.below(p));
}

}  // namespace panoptic
