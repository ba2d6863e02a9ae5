// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/surface_sampler.h"
#include "panoptic/map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/tracking/painted_room.h"

namespace panoptic {
namespace {

TEST(SurfaceSampler, TellsDistanceAndNormalOfAWall) {
  Mapper mapper = test::room_mapper();
  for (int n = 0; n < 3; ++n) {
    const Pose pose = test::look_at({0.2 * n, 0, 0}, {0.2 * n, 0, 2});
    ASSERT_TRUE(mapper.add(test::render(test::bare_wall(), test::room_camera(), pose, n), {}).used);
  }
  SurfaceSampler sampler(mapper.map().voxels);
  NearSurface sample;
  for (const double before_m : {-0.04, -0.01, 0.0, 0.02, 0.05}) {
    ASSERT_TRUE(sampler.at({0.1, 0.05, 2 - before_m}, sample)) << before_m;
    EXPECT_NEAR(sample.distance_m, before_m, 0.003);
    EXPECT_LT((sample.normal + Vec3f::UnitZ()).norm(), 0.05F);
  }
  EXPECT_FALSE(sampler.at({0.1, 0.05, 1}, sample));   // nothing is there
  EXPECT_FALSE(sampler.at({0.1, 0.05, 5}, sample));   // never seen
  EXPECT_FALSE(sampler.at({1e12, 0.05, 2}, sample));  // out of the map
  EXPECT_FALSE(sampler.at({NAN, 0.05, 2}, sample));
}

// The distance from the surface by eight voxels, each looked up by itself; nothing where one was never observed. `slope` is how
// much the stored distance grows in a step of one voxel, in voxels.
std::optional<double> by_voxels(const VoxelMap& map, const Vec3d& point_m, double& slope) {
  const Vec3d at = point_m / double{map.voxel_size_m()} - Vec3d::Constant(0.5);
  const Eigen::Vector3i first = at.array().floor().cast<int>();
  const Vec3d share = at - first.cast<double>();
  double sum = 0;
  Vec3d gradient = Vec3d::Zero();
  for (int n = 0; n < 8; ++n) {
    const Eigen::Vector3i step(n & 1, n >> 1 & 1, n >> 2);
    const Eigen::Vector3i v = first + step;
    const VoxelPlace place = place_of(VoxelIndex{v.x(), v.y(), v.z()});
    const VoxelBlock* block = map.find(place.block);
    if (block == nullptr || !(block->weight(place.offset) > 0)) return std::nullopt;
    const double distance = double{block->distance(place.offset)};
    const auto weight = [&](int axis) { return step[axis] == 1 ? share[axis] : 1 - share[axis]; };
    sum += weight(0) * weight(1) * weight(2) * distance;
    for (int axis = 0; axis < 3; ++axis) {
      gradient[axis] += (2 * step[axis] - 1) * weight((axis + 1) % 3) * weight((axis + 2) % 3) * distance;
    }
  }
  slope = gradient.norm() / double{map.voxel_size_m()};
  return sum / slope;
}

// A slanted wall: the corners of a point lie in one brick, two, four or eight, of one block or several.
TEST(SurfaceSampler, ReadsTheSameVoxelsAcrossBricksAndBlocks) {
  Mapper mapper = test::room_mapper();
  const Pose pose = test::look_at({0, 0, 0}, {0.5, 0.3, 2});
  ASSERT_TRUE(mapper.add(test::render(test::bare_wall(), test::room_camera(), pose, 0), {}).used);
  const VoxelMap& map = mapper.map().voxels;
  SurfaceSampler sampler(map);
  int compared = 0;
  int unknown = 0;
  for (int n = 0; n < 20000; ++n) {
    const double t = n * 0.618033988749895;
    const Vec3d point(0.2 + 0.6 * (t - std::floor(t)), 0.6 * n / 20000.0, 1.88 + 0.24 * (n % 37) / 36.0);
    NearSurface sample;
    double slope = 0;
    const std::optional<double> distance = by_voxels(map, point, slope);
    const bool is_near = sampler.at(point, sample);
    if (!distance) {
      EXPECT_FALSE(is_near) << point.transpose();
      ++unknown;
    } else if (slope > 0.51) {
      ASSERT_TRUE(is_near) << point.transpose();
      EXPECT_NEAR(double{sample.distance_m}, *distance, 1e-5) << point.transpose();
      ++compared;
    }
  }
  EXPECT_GT(compared, 5000);
  EXPECT_GT(unknown, 500);
}

}  // namespace
}  // namespace panoptic
