// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/surface_sampler.h"
#include "panoptic/map.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace panoptic
