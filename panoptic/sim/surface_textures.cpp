// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/surface_textures.h"

#include <algorithm>
#include <cmath>

#include "panoptic/sim/random.h"

namespace panoptic {
namespace {

constexpr int kSide_px = 512;

// Smooth noise in 0..1 with `cells_u` x `cells_v` values over the picture, which continue across its edges.
double smooth_noise(std::uint64_t seed, int u, int v, int cells_u, int cells_v) {
  const double x = static_cast<double>(u) * cells_u / kSide_px;
  const double y = static_cast<double>(v) * cells_v / kSide_px;
  const int left = static_cast<int>(x);
  const int top = static_cast<int>(y);
  const double right_share = x - left;
  const double bottom_share = y - top;
  const auto value = [&](int i, int j) {
    return unit_interval(hash_bits(seed, static_cast<std::uint64_t>(i % cells_u), static_cast<std::uint64_t>(j % cells_v)));
  };
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double a = std::lerp(value(left, top), value(left + 1, top), ease(right_share));
  const double b = std::lerp(value(left, top + 1), value(left + 1, top + 1), ease(right_share));
  return std::lerp(a, b, ease(bottom_share));
}

// Each gives the brightness of a pixel relative to the mean colour.
double plaster(std::uint64_t seed, int u, int v) {
  return 0.97 + 0.04 * smooth_noise(seed, u, v, 5, 5) + 0.05 * (smooth_noise(seed + 1, u, v, 128, 128) - 0.5);
}

double stripes(std::uint64_t seed, int u, int v) {
  const int width_px = 16 << (seed % 3);
  const bool is_dark = (u / width_px) % 2 == 0;
  return (is_dark ? 0.9 : 1.06) + 0.03 * (smooth_noise(seed, u, v, 128, 64) - 0.5);
}

// Eight boards across, each cut once at a place of its own.
double planks(std::uint64_t seed, int u, int v) {
  constexpr int kBoard_px = kSide_px / 16;
  const int board = v / kBoard_px;
  const int cut = static_cast<int>(hash_bits(seed, 7, static_cast<std::uint64_t>(board)) % kSide_px);
  const int half = (u - cut + kSide_px) % kSide_px < kSide_px / 2 ? 0 : 1;
  const double tone = unit_interval(hash_bits(seed, static_cast<std::uint64_t>(board), static_cast<std::uint64_t>(half)));
  const bool is_joint = v % kBoard_px == 0 || (u - cut + kSide_px) % (kSide_px / 2) == 0;
  const double grain = smooth_noise(seed + static_cast<std::uint64_t>(board), u, v, 8, 256) - 0.5;
  return is_joint ? 0.55 : 0.84 + 0.3 * tone + 0.14 * grain;
}

double tiles(std::uint64_t seed, int u, int v) {
  const int tile_px = seed % 2 == 0 ? 64 : 128;
  if (u % tile_px < 2 || v % tile_px < 2) return 0.72;
  const double tone =
      unit_interval(hash_bits(seed, static_cast<std::uint64_t>(u / tile_px), static_cast<std::uint64_t>(v / tile_px)));
  return 0.96 + 0.07 * tone + 0.04 * (smooth_noise(seed, u, v, 32, 32) - 0.5);
}

double carpet(std::uint64_t seed, int u, int v) {
  return 0.92 + 0.08 * smooth_noise(seed, u, v, 9, 9) + 0.24 * (smooth_noise(seed + 1, u, v, 256, 256) - 0.4);
}

double brightness(SurfaceFinish surface, std::uint64_t seed, int u, int v) {
  switch (surface) {
    case SurfaceFinish::kPlaster:
      return plaster(seed, u, v);
    case SurfaceFinish::kStripes:
      return stripes(seed, u, v);
    case SurfaceFinish::kPlanks:
      return planks(seed, u, v);
    case SurfaceFinish::kTiles:
      return tiles(seed, u, v);
    case SurfaceFinish::kCarpet:
      return carpet(seed, u, v);
  }
  return 1;
}

}  // namespace

Image<Rgb> surface_texture(SurfaceFinish surface, const Rgb& color, std::uint64_t seed) {
  Image<Rgb> picture(kSide_px, kSide_px);
  for (int v = 0; v < kSide_px; ++v) {
    for (int u = 0; u < kSide_px; ++u) {
      const double factor = brightness(surface, seed, u, v);
      const auto scaled = [&](std::uint8_t channel) {
        return static_cast<std::uint8_t>(std::clamp(channel * factor + 0.5, 0.0, 255.0));
      };
      picture(u, v) = {scaled(color.r), scaled(color.g), scaled(color.b)};
    }
  }
  return picture;
}

}  // namespace panoptic
