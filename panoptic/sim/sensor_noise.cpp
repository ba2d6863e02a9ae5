// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/sensor_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/sim/random.h"
#include "panoptic/sim/smooth_noise.h"

namespace panoptic {
namespace {

enum Purpose : std::uint64_t { kAxial = 1001, kFlying, kDropout, kExposure, kDrift };

// The depth camera's random numbers: one per pixel and purpose, whatever the order in which pixels are worked on.
struct PixelChance {
  PixelChance(std::uint64_t seed, Purpose purpose, std::int64_t frame)
      : base(hash_bits(seed, purpose, static_cast<std::uint64_t>(frame))) {}
  std::uint64_t bits(std::uint64_t u, std::uint64_t v) const { return mix_bits(base ^ (v << 32U | u)); }

  std::uint64_t base;
};

constexpr float kEdgeRatio = 0.95F;  // nearer than that share of a pixel's depth: another surface, not a slope

// The nearest foreground pixel within the reach, and how near it is.
struct Foreground {
  float depth = 0;
  float distance_px = 0;
};
Foreground foreground_of(const Image<float>& depth, int u, int v, float reach_px) {
  const int reach = static_cast<int>(reach_px);
  Foreground nearest{0, reach_px + 1};
  const float own = depth(u, v);
  for (int y = std::max(0, v - reach); y <= std::min(depth.height() - 1, v + reach); ++y) {
    for (int x = std::max(0, u - reach); x <= std::min(depth.width() - 1, u + reach); ++x) {
      const float other = depth(x, y);
      if (other <= 0 || other >= kEdgeRatio * own) continue;
      const auto distance_px = static_cast<float>(std::hypot(x - u, y - v));
      if (distance_px <= reach_px && distance_px < nearest.distance_px) nearest = {other, distance_px};
    }
  }
  return nearest;
}

// Looks only above, below and beside: enough to find out quickly that there is no edge near, which is so nearly everywhere.
bool is_near_edge(const Image<float>& depth, int u, int v, int reach) {
  const float limit = kEdgeRatio * depth(u, v);
  const auto is_nearer = [&](int x, int y) { return depth(x, y) > 0 && depth(x, y) < limit; };
  for (int d = 1; d <= reach; ++d) {
    if (u >= d && is_nearer(u - d, v)) return true;
    if (u + d < depth.width() && is_nearer(u + d, v)) return true;
    if (v >= d && is_nearer(u, v - d)) return true;
    if (v + d < depth.height() && is_nearer(u, v + d)) return true;
  }
  return false;
}

// A pixel beside the edge of something nearer sees part of both: its reading lies anywhere between.
void smear_edges(float reach_px, const PixelChance& chance, Image<float>& depth) {
  const Image<float> sharp = depth;
  const int reach = static_cast<int>(reach_px);
  parallel_for(static_cast<std::size_t>(depth.height()), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < depth.width(); ++u) {
      if (sharp(u, v) <= 0 || !is_near_edge(sharp, u, v, reach)) continue;
      const Foreground nearer = foreground_of(sharp, u, v, reach_px);
      if (nearer.depth <= 0) continue;
      const float share = static_cast<float>(unit_interval(chance.bits(u, v))) * (1 - nearer.distance_px / (reach_px + 1));
      depth(u, v) += share * (nearer.depth - depth(u, v));
    }
  });
}

// No reading: too far, too oblique, or too dark. Dark surfaces lose patches rather than single pixels.
bool is_lost(const SensorNoise& noise, const Rendering& rendering, int u, int v, const PixelChance& chance) {
  constexpr unsigned kPatchBits = 2;
  constexpr float kDark = 48;  // grey value from which nothing is lost
  if (noise.max_range_m > 0 && rendering.depth(u, v) > noise.max_range_m) return true;
  if (rendering.cos_incidence(u, v) < noise.min_cos_incidence) return true;
  if (noise.dark_dropout <= 0) return false;
  const Rgb& color = rendering.color(u, v);
  const float grey = 0.3F * color.r + 0.6F * color.g + 0.1F * color.b;
  if (grey >= kDark) return false;
  const auto patch_u = static_cast<unsigned>(u) >> kPatchBits;
  const auto patch_v = static_cast<unsigned>(v) >> kPatchBits;
  return unit_interval(chance.bits(patch_u, patch_v)) < noise.dark_dropout * (1 - grey / kDark);
}

// Sensors measure disparity, 1 / depth: noise and steps that are even there grow with depth squared.
float measured(const SensorNoise& noise, float depth, std::uint64_t bits) {
  float inverse = 1 / depth;
  if (noise.axial_m_per_m2 > 0) inverse += noise.axial_m_per_m2 * static_cast<float>(nearly_normal(bits));
  if (noise.quantum_m_per_m2 > 0) inverse = noise.quantum_m_per_m2 * std::round(inverse / noise.quantum_m_per_m2);
  constexpr float kLeastInverse = 1e-3F;
  return inverse > kLeastInverse ? 1 / inverse : 0;
}

void measure(const SensorNoise& noise, std::uint64_t seed, std::int64_t frame, Rendering& rendering) {
  const PixelChance axial(seed, kAxial, frame);
  const PixelChance dropout(seed, kDropout, frame);
  const bool is_exact = noise.axial_m_per_m2 <= 0 && noise.quantum_m_per_m2 <= 0;
  parallel_for(static_cast<std::size_t>(rendering.depth.height()), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < rendering.depth.width(); ++u) {
      float& depth = rendering.depth(u, v);
      if (depth <= 0) continue;
      if (is_lost(noise, rendering, u, v, dropout)) {
        depth = 0;
      } else if (!is_exact) {
        depth = measured(noise, depth, axial.bits(u, v));
      }
    }
  });
}

// The mean along the way that the image moved while the shutter was open.
void blur(const Eigen::Vector2f& motion_px, Image<Rgb>& color) {
  constexpr float kShutter = 0.5F;  // open for half of the time between frames
  constexpr int kMostTaps = 15;
  if (!motion_px.allFinite()) return;
  const Eigen::Vector2f way = motion_px * kShutter;
  const float length_px = way.lpNorm<Eigen::Infinity>();
  if (length_px < 0.5F) return;
  const int taps = std::min(kMostTaps, static_cast<int>(std::min(length_px, 1e4F)) + 2);
  std::array<Eigen::Vector2i, kMostTaps> offsets;
  for (int i = 0; i < taps; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(taps - 1) - 0.5F;
    const float limit = 1e4F;
    offsets[i] = (way * share).cwiseMax(-limit).cwiseMin(limit).array().round().cast<int>();
  }
  const Image<Rgb> sharp = color;
  parallel_for(static_cast<std::size_t>(color.height()), [&](std::size_t row) {
    for (int u = 0; u < color.width(); ++u) {
      int r = 0;
      int g = 0;
      int b = 0;
      for (int i = 0; i < taps; ++i) {
        const Rgb& tap = sharp(std::clamp(u + offsets[i].x(), 0, color.width() - 1),
                               std::clamp(static_cast<int>(row) + offsets[i].y(), 0, color.height() - 1));
        r += tap.r;
        g += tap.g;
        b += tap.b;
      }
      const auto mean = [&](int sum) { return static_cast<std::uint8_t>((sum + taps / 2) / taps); };
      color(u, static_cast<int>(row)) = {mean(r), mean(g), mean(b)};
    }
  });
}

// A smooth function of time with values in -1..1: waves of incommensurate periods.
double waves(std::uint64_t seed, std::uint64_t channel, double time_s) {
  Random random(seed, kExposure, channel);
  double sum = 0;
  for (const double period_s : {4.3, 9.7, 23.0}) {
    sum += std::sin(2 * std::numbers::pi * (time_s / period_s + random.uniform())) / 3;
  }
  return sum;
}

// Automatic exposure and white balance that never come to rest.
void expose(std::uint64_t seed, std::int64_t frame, Image<Rgb>& color) {
  constexpr double kGainSwing = 0.25;
  constexpr double kBalanceSwing = 0.06;
  const double time_s = static_cast<double>(frame) / kFrameRate_hz;
  const double brightness = std::exp(kGainSwing * waves(seed, 0, time_s));
  const double warmth = kBalanceSwing * waves(seed, 1, time_s);
  std::array<std::array<std::uint8_t, 256>, 3> tables{};
  const std::array<double, 3> gains{brightness * (1 + warmth), brightness, brightness * (1 - warmth)};
  for (int channel = 0; channel < 3; ++channel) {
    for (int value = 0; value < 256; ++value) {
      tables[channel][value] = static_cast<std::uint8_t>(std::min(255.0, value * gains[channel] + 0.5));
    }
  }
  for (std::size_t i = 0; i < color.size(); ++i) {
    color[i] = {tables[0][color[i].r], tables[1][color[i].g], tables[2][color[i].b]};
  }
}

Vec3d normal_vector(Random& random) {
  const double x = random.normal();
  const double y = random.normal();
  return {x, y, random.normal()};
}

}  // namespace

Fields fields(SensorNoise& noise) {
  return {
      {"axial_m_per_m2", &noise.axial_m_per_m2, "standard deviation of depth at 1 m; grows with depth squared", in_range(0, 0.1)},
      {"quantum_m_per_m2", &noise.quantum_m_per_m2, "depth step at 1 m; grows with depth squared", in_range(0, 0.1)},
      {"max_range_m", &noise.max_range_m, "no reading beyond; 0 = everywhere", in_range(0, 100)},
      {"min_cos_incidence", &noise.min_cos_incidence, "no reading where the surface is more oblique", in_range(0, 1)},
      {"dark_dropout", &noise.dark_dropout, "probability that a black surface gives no reading", in_range(0, 1)},
      {"flying_px", &noise.flying_px, "how far into the background depth edges are smeared", in_range(0, 8)},
      {"drift_m_per_s", &noise.drift_m_per_s, "random walk of the position: standard deviation per axis after a second",
       in_range(0, 1)},
      {"drift_rad_per_s", &noise.drift_rad_per_s, "the same of the orientation", in_range(0, 1)},
      {"motion_blur", &noise.motion_blur, "blur colour along the motion of the image", {}},
      {"exposure", &noise.exposure, "vary brightness and colour balance slowly", {}},
  };
}

SensorNoise sensor_noise_preset(const std::string& name) {
  SensorNoise noise;
  if (name == "none") return noise;
  noise.axial_m_per_m2 = 0.0015F;
  noise.quantum_m_per_m2 = 0.0028F;
  noise.max_range_m = 5;
  noise.min_cos_incidence = 0.12F;
  noise.dark_dropout = 0.6F;
  noise.flying_px = 1.5F;
  if (name == "kinect") return noise;
  noise.drift_m_per_s = 0.006F;
  noise.drift_rad_per_s = 0.0015F;
  if (name == "drift") return noise;
  noise.motion_blur = true;
  noise.exposure = true;
  if (name == "harsh") return noise;
  throw Error(fmt::format("there is no sensor noise '{}'; choose none, kinect, drift or harsh", name));
}

void add_sensor_noise(const SensorNoise& noise, std::uint64_t seed, std::int64_t frame_index, Rendering& rendering,
                      const Eigen::Vector2f& motion_px) {
  if (noise.flying_px >= 1) smear_edges(noise.flying_px, PixelChance(seed, kFlying, frame_index), rendering.depth);
  measure(noise, seed, frame_index, rendering);
  if (noise.motion_blur) blur(motion_px, rendering.color);
  if (noise.exposure) expose(seed, frame_index, rendering.color);
}

std::vector<Pose> with_drift(const SensorNoise& noise, std::uint64_t seed, const std::vector<Pose>& truth) {
  std::vector<Pose> tracked = truth;
  if (noise.drift_m_per_s <= 0 && noise.drift_rad_per_s <= 0) return tracked;
  const double root_of_step = std::sqrt(1 / kFrameRate_hz);  // the variance of a random walk grows with time
  for (std::size_t i = 1; i < truth.size(); ++i) {
    Random random(seed, kDrift, i);
    const Vec3d shift_m = noise.drift_m_per_s * root_of_step * normal_vector(random);
    const Vec3d turn_rad = noise.drift_rad_per_s * root_of_step * normal_vector(random);
    const double angle_rad = turn_rad.norm();
    Pose error = Pose::Identity();
    error.translation() = shift_m;
    if (angle_rad > 0) error.linear() = Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad).toRotationMatrix();
    const Pose before_from_now = truth[i - 1].inverse() * truth[i];
    // Thousands of products wear the rotation's orthonormality away.
    tracked[i] = rigid((tracked[i - 1] * before_from_now * error).matrix());
  }
  return tracked;
}

}  // namespace panoptic
