// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/thing_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace panoptic {
namespace {

// Two boxes of one thing seen from other sides differ by as much along an edge.
constexpr double kLeastAlike = 0.5;
constexpr double kLeastFilled = 0.25;  // of the largest side of its box: a chair fills half of it

}  // namespace

ExtentBox trimmed_box(std::vector<VoxelIndex> voxels, double voxel_m) {
  constexpr std::size_t kTrimmed = 50;
  ExtentBox box;
  const std::size_t cut = voxels.size() / kTrimmed;
  Vec3d sum = Vec3d::Zero();
  for (const VoxelIndex& at : voxels) sum += Vec3d(at[0], at[1], at[2]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::sort(voxels.begin(), voxels.end(), [&](const VoxelIndex& a, const VoxelIndex& b) { return a[axis] < b[axis]; });
    const auto a = static_cast<Eigen::Index>(axis);
    box.min_m[a] = voxel_m * voxels[cut][axis];
    box.max_m[a] = voxel_m * (voxels[voxels.size() - 1 - cut][axis] + 1);
    box.center_m[a] = voxel_m * (sum[a] / static_cast<double>(voxels.size()) + 0.5);
  }
  return box;
}

std::vector<VoxelIndex> main_part(const std::vector<VoxelIndex>& voxels) {
  std::map<CellIndex, std::vector<VoxelIndex>> bricks;
  for (const VoxelIndex& at : voxels) bricks[{at[0] >> 2, at[1] >> 2, at[2] >> 2}].push_back(at);
  std::vector<VoxelIndex> largest;
  while (!bricks.empty()) {
    std::vector<VoxelIndex> part;
    std::vector<CellIndex> queue{bricks.begin()->first};
    for (std::size_t n = 0; n < queue.size(); ++n) {
      const CellIndex cell = queue[n];
      const auto brick = bricks.find(cell);
      if (brick == bricks.end()) continue;
      part.insert(part.end(), brick->second.begin(), brick->second.end());
      bricks.erase(brick);
      for (int k = 0; k < kNeighbours; ++k) {
        const BlockIndex step = step_to(k);
        const CellIndex beside{cell[0] + step.x, cell[1] + step.y, cell[2] + step.z};
        if (bricks.contains(beside)) queue.push_back(beside);
      }
    }
    if (part.size() > largest.size()) largest = std::move(part);
  }
  if (2 * largest.size() <= voxels.size()) largest.clear();
  return largest;
}

bool is_inside(const ExtentBox& box, const VoxelIndex& at, double voxel_m, double wider_m) {
  const Vec3d middle_m = (Vec3d(at[0], at[1], at[2]) + Vec3d::Constant(0.5)) * voxel_m;
  return ((middle_m - box.min_m).array() > -wider_m).all() && ((box.max_m - middle_m).array() > -wider_m).all();
}

double area_of(std::uint64_t voxels, double voxel_m) {
  return static_cast<double>(voxels) / (2 * double{kSurfaceBand_voxels}) * voxel_m * voxel_m;
}

bool is_thing(const std::vector<VoxelIndex>& surface, double voxel_m, PastObject& past) {
  const std::vector<VoxelIndex> body = main_part(surface);
  if (body.empty()) return false;
  past.voxels = body.size();
  past.box = trimmed_box(body, voxel_m);
  const double area_m2 = area_of(body.size(), voxel_m);
  const Vec3d edges = past.box.max_m - past.box.min_m;
  return area_m2 >= kLeastArea_m2 && area_m2 >= kLeastFilled * edges.prod() / edges.minCoeff();
}

double share_of(double a, double b) { return std::min(a, b) / std::max({a, b, 1e-6}); }

double likeness(const ExtentBox& a, const ExtentBox& b) {
  const auto edges = [](const ExtentBox& box) {
    std::array<double, 3> e{};
    for (int axis = 0; axis < 3; ++axis) e[static_cast<std::size_t>(axis)] = box.max_m[axis] - box.min_m[axis];
    std::sort(e.begin(), e.end());
    return e;
  };
  const auto ea = edges(a);
  const auto eb = edges(b);
  double alike = 1;
  for (std::size_t n = 0; n < 3; ++n) {
    const double edge = share_of(ea[n], eb[n]);
    if (edge < kLeastAlike) return 0;
    alike *= edge;
  }
  return alike;
}

}  // namespace panoptic
