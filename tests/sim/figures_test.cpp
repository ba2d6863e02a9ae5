// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/figures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "panoptic/sim/bodies.h"
#include "panoptic/sim/random.h"
#include "tests/sim/box_room.h"

namespace panoptic::test {
namespace {

double distance_m(const Limb& limb, const Vec3d& p) {
  const Vec3d from = limb.from.cast<double>();
  const Vec3d axis = limb.to.cast<double>() - from;
  const double along = axis.squaredNorm() > 0 ? std::clamp((p - from).dot(axis) / axis.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - from - along * axis).norm();
}

// Follows the ray in steps that cannot pass through anything.
double march(const Limb& limb, const Vec3d& origin, const Vec3d& direction) {
  const double unit = direction.norm();
  double at = 0;
  for (int i = 0; i < 4000 && at < 20; ++i) {
    const double gap_m = distance_m(limb, origin + at * direction) - static_cast<double>(limb.radius_m);
    if (gap_m < 1e-7) return at;
    at += gap_m / unit;
  }
  return 0;
}

TEST(Figures, ALimbIsMetWhereMarchingMeetsIt) {
  Random random(1);
  const auto point = [&](double size_m) {
    const double x = random.uniform(-size_m, size_m);
    const double y = random.uniform(-size_m, size_m);
    return Vec3d(x, y, random.uniform(-size_m, size_m));
  };
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    Limb limb;
    limb.from = (point(0.3) + Vec3d(0, 0, 2)).cast<float>();
    limb.to = i % 5 == 0 ? limb.from : Vec3f((point(0.3) + Vec3d(0, 0, 2)).cast<float>());
    if (i % 7 == 0) limb.to = limb.from + Vec3f(0, 0, 0.3F);  // along the ray
    limb.radius_m = static_cast<float>(random.uniform(0.05, 0.2));
    const Vec3d direction = i % 7 == 0 ? Vec3d(0, 0, 1.5) : Vec3d(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 1);
    const double expected = march(limb, Vec3d::Zero(), direction);
    const double actual = enter(limb, Vec3d::Zero(), direction);
    if (expected == 0) {
      // A ray that grazes the limb may be taken for one that misses it.
      if (actual > 0) {
        EXPECT_NEAR(distance_m(limb, actual * direction), static_cast<double>(limb.radius_m), 1e-4) << i;
      }
      continue;
    }
    EXPECT_NEAR(actual, expected, 1e-3) << i;
    ++met;
  }
  EXPECT_GT(met, 300);
}

TEST(Figures, ALimbBehindTheEyeIsNotMet) {
  const Limb limb{Vec3f(0, 0, -2), Vec3f(0.2F, 0, -1), 0.1F, {}};
  EXPECT_EQ(enter(limb, Vec3d::Zero(), Vec3d(0, 0, 1)), 0);
}

TEST(Figures, ThePictureIsThatOfEveryLimbAtEveryPixel) {
  Random random(5);
  BodyPose standing;
  standing.at = {0.1, 2};
  BodyPose near = standing;
  near.at = {0.3, 0.4};  // partly beside and behind the eye
  const std::vector<Figure> figures = {
      {kPersonClass, 7, limbs_of(random_body(BodyKind::kPerson, random), standing)},
      {kDogClass, 8, limbs_of(random_body(BodyKind::kDog, random), near)},
  };
  const Camera camera = resized(small_camera(), 80, 60);
  const Pose eye = looking({0, 0, 1.2}, {0.1, 2, 0.8});
  const FigureLayer layer = draw_figures(figures, camera, eye);
  int shown = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Vec3d direction = eye.linear() * back_project(camera, u, v, 1);
      double nearest = 0;
      for (const Figure& figure : figures) {
        for (const Limb& limb : figure.limbs) {
          const double depth = enter(limb, eye.translation(), direction);
          if (depth > 0 && (nearest == 0 || depth < nearest)) nearest = depth;
        }
      }
      ASSERT_NEAR(static_cast<double>(layer.pixels(u, v).depth_m), nearest, 2e-3) << u << ' ' << v;
      shown += nearest > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(shown, 300);
}

TEST(Bodies, StandOnTheFloorAndAreAsTallAsTheyShould) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const Body body = random_body(BodyKind::kPerson, random);
    BodyPose pose;
    for (double walked_m = 0; walked_m < 1.3; walked_m += 0.1) {
      pose.walked_m = walked_m;
      pose.stride = 1;
      const Eigen::AlignedBox3d box = box_of(Figure{kPersonClass, 1, limbs_of(body, pose)});
      EXPECT_GE(box.min().z(), -1e-6);
      EXPECT_LT(box.min().z(), 0.02);
      EXPECT_NEAR(box.max().z(), body.height_m, 0.1);
      EXPECT_LT(box.sizes().head<2>().maxCoeff(), 1.1);
    }
  }
}

TEST(Bodies, WhoSitsIsOnTheSeatWithBothFeetOnTheFloor) {
  Random random(4);
  const Body body = random_body(BodyKind::kPerson, random);
  BodyPose pose;
  pose.heading = 0.7;
  pose.down = 1;
  pose.seat = Vec3d(-0.45 * std::cos(0.7), -0.45 * std::sin(0.7), 0.45);
  const std::vector<Limb> limbs = limbs_of(body, pose);
  const Eigen::AlignedBox3d box = box_of(Figure{kPersonClass, 1, limbs});
  EXPECT_GE(box.min().z(), -1e-6);
  EXPECT_LT(box.min().z(), 0.02);
  EXPECT_LT(box.max().z(), 0.85 * body.height_m);
  EXPECT_GT(box.max().z(), 0.6 * body.height_m);
}

}  // namespace
}  // namespace panoptic::test
