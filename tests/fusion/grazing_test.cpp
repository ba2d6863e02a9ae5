// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/grazing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "panoptic/fusion/integrator.h"
#include "panoptic/map/voxel_grid.h"
#include "tests/fusion/naive_grazing.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

constexpr float kVoxel_m = 0.024F;
const Band kBand{4 * kVoxel_m, kVoxel_m};

struct Depths {
  explicit Depths(const test::Surface& surface, const Pose& pose = Pose::Identity()) {
    const Camera camera = test::small_camera();
    const Frame image = test::render(surface, camera, pose);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) depth.push_back(image.depth(u, v));
    }
    depth.push_back(0);
    frame.width = camera.width;
    frame.height = camera.height;
    frame.fx = frame.fy = static_cast<float>(camera.fx);
    frame.cx = static_cast<float>(camera.cx);
    frame.cy = static_cast<float>(camera.cy);
  }

  const std::vector<float>& scales() {
    frame.depth = depth.data();
    grazing_scales(frame, kBand, kVoxel_m, scale);
    return scale;
  }

  std::vector<float> depth;
  std::vector<float> scale;
  KernelFrame frame;
};

// The plane through (0, 0, 2) that the middle of the view meets at this cosine.
test::Surface slanted(double cosine) {
  const Vec3d normal(std::sqrt(1 - cosine * cosine), 0, cosine);
  return test::plane(normal, normal.z() * 2);
}

TEST(Grazing, ScaleIsTheBandAcrossTheSurfaceOverTwoVoxels) {
  for (const double cosine : {0.9, 0.4, 0.3, 0.2}) {
    Depths view(slanted(cosine));
    EXPECT_NEAR(view.scales()[60 * 160 + 80], std::min(1.0, 2 * cosine), 0.02) << cosine;
  }
}

TEST(Grazing, NoBandGetsLongerThanFourTimesItsLength) {
  Depths view(slanted(0.05));
  EXPECT_EQ(view.scales()[60 * 160 + 80], 0.25F);
}

TEST(Grazing, EqualsTheNaiveDefinition) {
  const auto scene =
      test::nearest_of({test::sphere({0, 0, 0}, 0.6), test::plane(Vec3d::UnitY(), 0.6), test::plane(Vec3d::UnitX(), 1.5)});
  Depths view(scene, test::look_at({-2, -0.3, 0.4}, {0.3, 0.2, 0}));
  for (std::size_t i = 0; i < view.depth.size(); i += 97) view.depth[i] = 0;
  const std::vector<float>& scale = view.scales();
  int grazing = 0;
  int different = 0;
  for (int v = 0; v < view.frame.height; ++v) {
    for (int u = 0; u < view.frame.width; ++u) {
      const double expected = test::naive_scale(view.frame, kBand, double{kVoxel_m}, u, v);
      grazing += expected < 1 ? 1 : 0;
      different +=
          std::abs(static_cast<double>(scale[static_cast<std::size_t>(v * view.frame.width + u)]) - expected) > 1e-3 ? 1 : 0;
    }
  }
  EXPECT_GT(grazing, 500);
  EXPECT_LE(different, 10) << "float and double may differ about what is straight";
  EXPECT_EQ(scale.back(), 1.0F) << "the pixel that stands for no reading";
}

// A step from 1 m to 3 m, sharp or with a pixel between as sensors give it, is no surface seen at a grazing angle.
TEST(Grazing, BordersOfObjectsAreNoSlopes) {
  for (const float between : {1.0F, 1.5F, 3.0F}) {
    Depths view(test::plane(Vec3d::UnitZ(), 1));
    for (int v = 0; v < view.frame.height; ++v) {
      for (int u = 80; u < view.frame.width; ++u)
        view.depth[static_cast<std::size_t>(v * view.frame.width + u)] = u == 80 ? between : 3.0F;
    }
    const std::vector<float>& scale = view.scales();
    EXPECT_EQ(std::count(scale.begin(), scale.end(), 1.0F), static_cast<std::ptrdiff_t>(scale.size())) << between;
  }
}

// The share of a wall's middle, by columns of voxels across it, that holds its surface: observed on both sides of it.
double found_share(bool grazing) {
  VoxelMap map({kVoxel_m, 4});
  Integrator integrator({.grazing = grazing}, map);
  Registration registration({});
  // Along a wall that lies near the centres of voxels, at cosines of .1 to .2.
  const test::Surface wall = test::plane(Vec3d::UnitY(), 0.4 * double{kVoxel_m});
  for (int i = 0; i < 4; ++i) {
    const Frame frame = test::render(wall, test::small_camera(320, 240),
                                     test::look_at({0.1 * i, -0.35, 0}, {2.5 + 0.1 * i, 0, 0}, Vec3d::UnitZ()), i);
    const RegisteredFrame& registered = registration.apply(frame, {});
    const std::vector<LabelSlot> labels(registered.depth.size(), LabelSlot::kNoVote);
    integrator.integrate(frame, registered, labels, map);
  }
  int found = 0;
  int all = 0;
  for (double x = 2; x < 3; x += double{kVoxel_m}) {
    for (double z = -0.4; z < 0.4; z += double{kVoxel_m}) {
      const auto weight_at = [&](double y) {
        const VoxelPlace place = *place_of(Vec3d(x, y, z), double{kVoxel_m});
        const VoxelBlock* block = map.find(place.block);
        return block == nullptr ? 0.0F : block->weight(place.offset);
      };
      ++all;
      found += weight_at(-0.5 * double{kVoxel_m}) > 0 && weight_at(0.5 * double{kVoxel_m}) > 0 ? 1 : 0;
    }
  }
  return static_cast<double>(found) / all;
}

TEST(Grazing, AWallSeenFlatIsFoundWhole) {
  EXPECT_GT(found_share(true), 0.99);
  EXPECT_LT(found_share(false), 0.9) << "else this test shows nothing";
}

}  // namespace
}  // namespace panoptic
