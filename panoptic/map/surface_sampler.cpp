// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/surface_sampler.h"

namespace panoptic {
namespace {

// Along a ray the stored distance grows by 1 a metre, so its gradient is 1 / cosine of the view, between 1 and about 4. It is
// smaller where the truncation cuts it, or where two surfaces meet.
constexpr float kLeastGradient = 0.5F;

}  // namespace

bool SurfaceSampler::corner(const VoxelIndex& voxel, float& distance) {
  const VoxelPlace place = place_of(voxel);
  const VoxelBlock* block = lookup_.find(place.block);
  if (block == nullptr) return false;
  const Brick& brick = block->brick(brick_of(place.offset));
  const int number = voxel_in_brick(place.offset);
  if ((brick.stored() >> number & 1) == 0) return false;
  const int at = brick.place(number);
  distance = brick.plane(FloatPlane::kDistance)[at];
  return brick.plane(FloatPlane::kWeight)[at] > 0;
}

bool SurfaceSampler::at(const Vec3d& point_m, NearSurface& sample) {
  const Vec3d voxels = point_m * per_voxel_ - Vec3d::Constant(0.5);
  const Vec3d whole = voxels.array().floor();
  constexpr double kFarthest = double{kMaxBlockCoordinate - 1} * kBlockSide;
  if (!(whole.cwiseAbs().maxCoeff() < kFarthest)) return false;
  const Eigen::Vector3i v = whole.cast<int>();
  const Vec3f t = (voxels - whole).cast<float>();
  std::array<float, 8> d{};
  for (std::size_t i = 0; i < d.size(); ++i) {
    const int n = static_cast<int>(i);
    if (!corner({v.x() + (n & 1), v.y() + (n >> 1 & 1), v.z() + (n >> 2)}, d[i])) return false;
  }
  // Along x first: four edges, and how the distance changes along each.
  const auto mix = [](float a, float b, float share) { return a + share * (b - a); };
  const std::array<float, 4> x = {mix(d[0], d[1], t.x()), mix(d[2], d[3], t.x()), mix(d[4], d[5], t.x()), mix(d[6], d[7], t.x())};
  const std::array<float, 2> y = {mix(x[0], x[1], t.y()), mix(x[2], x[3], t.y())};
  const Vec3f gradient(mix(mix(d[1] - d[0], d[3] - d[2], t.y()), mix(d[5] - d[4], d[7] - d[6], t.y()), t.z()),
                       mix(x[1] - x[0], x[3] - x[2], t.z()), y[1] - y[0]);
  const float length = gradient.norm();
  if (length < kLeastGradient * voxel_m_) return false;
  sample.normal = gradient / length;
  sample.distance_m = mix(y[0], y[1], t.z()) * (voxel_m_ / length);
  return true;
}

}  // namespace panoptic
