// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/sensor_noise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "panoptic/base/config.h"
#include "panoptic/parallel.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using testing::HasSubstr;

constexpr Rgb kGrey{128, 128, 128};

// A wall that faces the camera.
Rendering wall(float depth_m, const Rgb& color = kGrey, int width = 200, int height = 150) {
  return {Image<float>(width, height, depth_m), Image<Rgb>(width, height, color), Image<ClassId>(width, height, ClassId{1}),
          Image<std::uint16_t>(width, height), Image<float>(width, height, 1.0F)};
}

Rendering noisy(const SensorNoise& noise, Rendering rendering, std::int64_t frame = 0, std::uint64_t seed = 1) {
  add_sensor_noise(noise, seed, frame, rendering, Eigen::Vector2f::Zero());
  return rendering;
}

struct Statistics {
  double mean = 0;
  double deviation = 0;
};
Statistics statistics(const std::vector<double>& values) {
  double sum = 0;
  double squares = 0;
  for (const double value : values) sum += value;
  const double mean = sum / static_cast<double>(values.size());
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / static_cast<double>(values.size()))};
}
Statistics statistics(const Image<float>& depth) {
  return statistics(std::vector<double>(depth.pixels().begin(), depth.pixels().end()));
}

double share_without_reading(const Image<float>& depth) {
  return static_cast<double>(std::count(depth.pixels().begin(), depth.pixels().end(), 0.0F)) / static_cast<double>(depth.size());
}

TEST(SensorNoise, NoneChangesNothing) {
  const Rendering rendering = noisy(sensor_noise_preset("none"), wall(2));
  EXPECT_EQ(rendering.depth, wall(2).depth);
  EXPECT_EQ(rendering.color, wall(2).color);
}

TEST(SensorNoise, AxialNoiseGrowsWithDepthSquared) {
  const SensorNoise noise{.axial_m_per_m2 = 0.0015F};
  for (const float depth_m : {0.7F, 1.0F, 2.0F, 4.0F}) {
    const Statistics found = statistics(noisy(noise, wall(depth_m)).depth);
    const double expected = 0.0015 * depth_m * depth_m;
    EXPECT_NEAR(found.deviation, expected, 0.1 * expected) << depth_m;
    EXPECT_NEAR(found.mean, depth_m, 0.1 * expected);
  }
}

TEST(SensorNoise, NeighboursErrIndependently) {
  const Image<float> depth = noisy({.axial_m_per_m2 = 0.0015F}, wall(2)).depth;
  const Statistics all = statistics(depth);
  for (const auto& [du, dv] : {std::pair{1, 0}, std::pair{0, 1}, std::pair{1, 1}, std::pair{16, 0}}) {
    double products = 0;
    int count = 0;
    for (int v = 0; v + dv < depth.height(); ++v) {
      for (int u = 0; u + du < depth.width(); ++u, ++count)
        products += (depth(u, v) - all.mean) * (depth(u + du, v + dv) - all.mean);
    }
    EXPECT_NEAR(products / count / (all.deviation * all.deviation), 0, 0.03) << du << ' ' << dv;
  }
}

TEST(SensorNoise, StepsOfDepthGrowWithDepthSquared) {
  const SensorNoise noise{.quantum_m_per_m2 = 0.0028F};
  for (const float depth_m : {1.0F, 2.0F, 4.0F}) {
    Rendering ramp = wall(depth_m, kGrey, 400, 1);
    for (int u = 0; u < 400; ++u) ramp.depth(u, 0) = depth_m * (1 + 0.0002F * static_cast<float>(u));
    const Rendering found = noisy(noise, ramp);
    const std::set<float> levels(found.depth.pixels().begin(), found.depth.pixels().end());
    // 8 % of the depth in steps of 0.0028 * depth^2 (with the mean depth squared).
    const double expected = 0.08 * depth_m / (0.0028 * depth_m * depth_m * 1.08);
    EXPECT_NEAR(static_cast<double>(levels.size()), expected, 0.1 * expected + 1.5);
    for (int u = 0; u < 400; ++u)
      EXPECT_LE(std::abs(found.depth(u, 0) - ramp.depth(u, 0)), 0.6 * 0.0028 * std::pow(ramp.depth(u, 0), 2));
  }
}

TEST(SensorNoise, FarAndObliqueSurfacesGiveNoReading) {
  const SensorNoise noise{.max_range_m = 3, .min_cos_incidence = 0.2F};
  EXPECT_EQ(share_without_reading(noisy(noise, wall(2.99F)).depth), 0);
  EXPECT_EQ(share_without_reading(noisy(noise, wall(3.01F)).depth), 1);
  Rendering oblique = wall(2);
  oblique.cos_incidence = Image<float>(200, 150, 0.19F);
  EXPECT_EQ(share_without_reading(noisy(noise, oblique).depth), 1);
  oblique.cos_incidence = Image<float>(200, 150, 0.21F);
  EXPECT_EQ(share_without_reading(noisy(noise, oblique).depth), 0);
}

TEST(SensorNoise, DarkSurfacesLoseTheStatedShare) {
  const SensorNoise noise{.dark_dropout = 0.6F};
  EXPECT_NEAR(share_without_reading(noisy(noise, wall(2, Rgb{0, 0, 0}, 640, 480)).depth), 0.6, 0.02);
  EXPECT_NEAR(share_without_reading(noisy(noise, wall(2, Rgb{24, 24, 24}, 640, 480)).depth), 0.3, 0.02);
  EXPECT_EQ(share_without_reading(noisy(noise, wall(2, kGrey)).depth), 0);
}

// The left half 1 m away, the right half 3 m.
Rendering step() {
  Rendering rendering = wall(3);
  for (int v = 0; v < 150; ++v) {
    for (int u = 0; u < 100; ++u) rendering.depth(u, v) = 1;
  }
  return rendering;
}

TEST(SensorNoise, PixelsBesideAnEdgeFlyBetweenItsDepths) {
  const Image<float> depth = noisy({.flying_px = 2}, step()).depth;
  double nearest_column = 0;
  double next_column = 0;
  for (int v = 0; v < 150; ++v) {
    for (int u = 0; u < 200; ++u) {
      if (u == 100 || u == 101) {
        EXPECT_GE(depth(u, v), 1);
        EXPECT_LE(depth(u, v), 3);
        (u == 100 ? nearest_column : next_column) += (3 - depth(u, v)) / 150;
      } else {
        EXPECT_EQ(depth(u, v), step().depth(u, v)) << u;
      }
    }
  }
  // A uniform share of the 2 m, up to 2/3 in the first column and 1/3 in the second.
  EXPECT_NEAR(nearest_column, 2.0 / 3, 0.1);
  EXPECT_NEAR(next_column, 1.0 / 3, 0.05);
}

TEST(SensorNoise, SlopesDoNotFly) {
  Rendering slope = wall(2);
  for (int v = 0; v < 150; ++v) {
    for (int u = 0; u < 200; ++u) slope.depth(u, v) = 1 + 0.02F * static_cast<float>(u);
  }
  EXPECT_EQ(noisy({.flying_px = 2}, slope).depth, slope.depth);
}

TEST(SensorNoise, MotionBlursAlongTheMotionAlone) {
  Rendering bars = wall(2);
  for (int v = 0; v < 150; ++v) {
    for (int u = 0; u < 200; ++u) bars.color(u, v) = u < 100 ? Rgb{0, 0, 0} : Rgb{200, 200, 200};
  }
  const auto blurred = [&](float x, float y) {
    Rendering rendering = bars;
    add_sensor_noise({.motion_blur = true}, 1, 0, rendering, {x, y});
    return rendering;
  };
  EXPECT_EQ(blurred(0, 20).color, bars.color) << "bars that move along themselves stay sharp";
  EXPECT_EQ(blurred(0.5F, 0).color, bars.color);
  const Image<Rgb> color = blurred(16, 0).color;
  // The shutter is open for half of the 16 pixels: a ramp of 8 pixels around the edge.
  EXPECT_EQ(color(94, 75), (Rgb{0, 0, 0}));
  EXPECT_NEAR(color(100, 75).g, 105, 20);
  EXPECT_EQ(color(105, 75), (Rgb{200, 200, 200}));
  for (int u = 95; u < 105; ++u) EXPECT_LE(color(u, 75).g, color(u + 1, 75).g);
  EXPECT_EQ(blurred(16, 0).depth, bars.depth);
  EXPECT_EQ(blurred(NAN, 3).color, bars.color);
  blurred(1e30F, -1e30F);
}

TEST(SensorNoise, ExposureChangesSlowlyAndWithinBounds) {
  const auto grey = [](std::int64_t frame) { return noisy({.exposure = true}, wall(2), frame).color(0, 0); };
  int darkest = 255;
  int brightest = 0;
  for (std::int64_t frame = 0; frame < 1800; ++frame) {
    const Rgb now = grey(frame);
    const Rgb next = grey(frame + 1);
    EXPECT_LE(std::abs(now.g - next.g), 3) << frame;
    EXPECT_LE(std::abs(now.r - now.b), 0.13 * now.g + 2);
    darkest = std::min<int>(darkest, now.g);
    brightest = std::max<int>(brightest, now.g);
  }
  EXPECT_GT(brightest - darkest, 25);
  EXPECT_GE(darkest, 128 * std::exp(-0.25) - 1);
  EXPECT_LE(brightest, 128 * std::exp(0.25) + 1);
}

TEST(SensorNoise, DependsOnSeedAndFrameAlone) {
  const SensorNoise noise = sensor_noise_preset("harsh");
  const Image<float> seventh = noisy(noise, step(), 7).depth;
  noisy(noise, wall(1), 3);
  EXPECT_EQ(noisy(noise, step(), 7).depth, seventh);
  EXPECT_NE(noisy(noise, step(), 8).depth, seventh);
  EXPECT_NE(noisy(noise, step(), 7, 2).depth, seventh);
  set_thread_count(1);
  const Image<float> on_one_thread = noisy(noise, step(), 7).depth;
  set_thread_count(4);
  EXPECT_EQ(noisy(noise, step(), 7).depth, on_one_thread);
  set_thread_count(0);
}

// A camera that walks in a circle.
std::vector<Pose> circle(int frames) {
  std::vector<Pose> poses;
  for (int i = 0; i < frames; ++i) {
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(0.01 * i, Vec3d::UnitZ()).toRotationMatrix();
    pose.translation() = pose.linear() * Vec3d(2, 0, 1.5);
    poses.push_back(pose);
  }
  return poses;
}

TEST(SensorNoise, DriftIsARandomWalkFromTheTruth) {
  constexpr int kSeconds = 4;
  const std::vector<Pose> truth = circle(30 * kSeconds + 1);
  std::vector<double> shifts;
  std::vector<double> turns;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const std::vector<Pose> shifted = with_drift({.drift_m_per_s = 0.01F}, seed, truth);
    EXPECT_TRUE(shifted.front().isApprox(truth.front()));
    const Vec3d shift = shifted.back().translation() - truth.back().translation();
    const std::vector<Pose> turned = with_drift({.drift_rad_per_s = 0.002F}, seed, truth);
    const Eigen::AngleAxisd turn(turned.back().linear() * truth.back().linear().transpose());
    for (int axis = 0; axis < 3; ++axis) {
      shifts.push_back(shift[axis]);
      turns.push_back(turn.angle() * turn.axis()[axis]);
    }
    EXPECT_TRUE(is_rigid(turned.back(), 1e-9));
  }
  EXPECT_NEAR(statistics(shifts).deviation, 0.01 * std::sqrt(kSeconds), 0.1 * 0.01 * std::sqrt(kSeconds));
  EXPECT_NEAR(statistics(turns).deviation, 0.002 * std::sqrt(kSeconds), 0.1 * 0.002 * std::sqrt(kSeconds));
  EXPECT_NEAR(statistics(shifts).mean, 0, 0.002);
}

TEST(SensorNoise, WithoutDriftTheTruthIsReported) {
  const std::vector<Pose> truth = circle(10);
  const std::vector<Pose> tracked = with_drift(sensor_noise_preset("kinect"), 1, truth);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(tracked[i].matrix(), truth[i].matrix());
}

TEST(SensorNoise, PresetsGrowAndUnknownOnesAreRefused) {
  EXPECT_EQ(sensor_noise_preset("kinect").drift_m_per_s, 0);
  EXPECT_GT(sensor_noise_preset("drift").drift_m_per_s, 0);
  EXPECT_FALSE(sensor_noise_preset("drift").motion_blur);
  EXPECT_TRUE(sensor_noise_preset("harsh").exposure);
  EXPECT_THAT(test::error_of([] { sensor_noise_preset("kinetc"); }), HasSubstr("none, kinect, drift or harsh"));
}

TEST(SensorNoise, FieldsNameEveryEffectAndItsRange) {
  SensorNoise noise;
  set_field(fields(noise), "flying_px=2.5");
  set_field(fields(noise), "motion_blur=true");
  EXPECT_EQ(noise.flying_px, 2.5F);
  EXPECT_TRUE(noise.motion_blur);
  EXPECT_THAT(test::error_of([&] { set_field(fields(noise), "dark_dropout=1.5"); }), HasSubstr("dark_dropout"));
}

}  // namespace
}  // namespace panoptic
