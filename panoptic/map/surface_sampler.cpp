// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/surface_sampler.h"

namespace panoptic {
namespace {

// Along a ray the stored distance grows by 1 a metre, so its gradient is 1 / cosine of the view, between 1 and about 4. It is
// smaller where the truncation cuts it, or where two surfaces meet.
constexpr float kLeastGradient = 0.5F;

}  // namespace

// The corners that one brick holds: all eight in two of five cases, and rarely one alone. Two that are neighbours along x lie
// side by side there.
bool SurfaceSampler::corners_in_brick(const VoxelIndex& first, unsigned split, unsigned far, std::array<float, 8>& distance) {
  const auto at_axis = [&](std::size_t axis) { return first[axis] + static_cast<int>(far >> axis & 1); };
  const VoxelPlace place = place_of(VoxelIndex{at_axis(0), at_axis(1), at_axis(2)});
  const VoxelBlock* block = lookup_.find(place.block);
  if (block == nullptr) return false;
  const Brick& brick = block->brick(brick_of(place.offset));
  const int number = voxel_in_brick(place.offset);
  const float* distances = brick.plane(FloatPlane::kDistance);
  const float* weights = brick.plane(FloatPlane::kWeight);
  const bool is_pair = (split & 1) == 0;
  const std::uint64_t wanted = is_pair ? 3 : 1;
  for (unsigned i = far & 1; i < 8; i += 2) {
    if ((i & split) != far) continue;
    const unsigned step = i & ~split;
    const int n = number + static_cast<int>((step >> 1 & 1) << 2 | (step >> 2) << 4);
    if ((brick.stored() >> n & wanted) != wanted) return false;
    const int at = brick.place(n);
    if (!(weights[at] > 0)) return false;
    distance[i] = distances[at];
    if (!is_pair) continue;
    if (!(weights[at + 1] > 0)) return false;
    distance[i + 1] = distances[at + 1];
  }
  return true;
}

bool SurfaceSampler::corners(const VoxelIndex& first, std::array<float, 8>& distance) {
  unsigned split = 0;  // a bit for each axis along which a brick ends between the corners
  for (std::size_t axis = 0; axis < 3; ++axis) split |= static_cast<unsigned>((first[axis] & 3) == 3) << axis;
  unsigned far = 0;  // of these, the axes along which the brick is the second one
  do {
    if (!corners_in_brick(first, split, far, distance)) return false;
    far = (far - split) & split;
  } while (far != 0);
  return true;
}

bool SurfaceSampler::at(const Vec3d& point_m, NearSurface& sample) {
  const Vec3d voxels = point_m * per_voxel_ - Vec3d::Constant(0.5);
  const Vec3d whole = voxels.array().floor();
  constexpr double kFarthest = double{kMaxBlockCoordinate - 1} * kBlockSide;
  if (!(whole.cwiseAbs().maxCoeff() < kFarthest)) return false;
  const Eigen::Vector3i v = whole.cast<int>();
  const Vec3f t = (voxels - whole).cast<float>();
  std::array<float, 8> d{};
  if (!corners({v.x(), v.y(), v.z()}, d)) return false;
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
