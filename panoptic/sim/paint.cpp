// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "panoptic/sim/random.h"

namespace panoptic {
namespace {

constexpr double kPi = std::numbers::pi;

Rgb shaded(Rgb color, double factor) {
  const auto channel = [&](std::uint8_t value) { return static_cast<std::uint8_t>(std::clamp(value * factor, 0.0, 255.0)); };
  return {channel(color.r), channel(color.g), channel(color.b)};
}

Rgb mixed(Rgb a, Rgb b, double share_of_b) {
  const auto channel = [&](std::uint8_t x, std::uint8_t y) { return static_cast<std::uint8_t>(x + (y - x) * share_of_b); };
  return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

Image<Rgb> painted(int width, int height, const std::function<Rgb(double, double)>& at) {
  Image<Rgb> image(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) image(u, v) = at((u + 0.5) / width, (v + 0.5) / height);
  }
  return image;
}

// Smooth noise in 0..1 that repeats with period 1; `columns` x `rows` random values, interpolated.
class Noise {
 public:
  Noise(std::uint64_t seed, int columns, int rows) : seed_(seed), columns_(columns), rows_(rows) {}

  double operator()(double u, double v) const {
    const double x = u * columns_;
    const double y = v * rows_;
    const double fx = smooth(x - std::floor(x));
    const double fy = smooth(y - std::floor(y));
    const int i = static_cast<int>(std::floor(x));
    const int j = static_cast<int>(std::floor(y));
    const double top = value(i, j) * (1 - fx) + value(i + 1, j) * fx;
    const double bottom = value(i, j + 1) * (1 - fx) + value(i + 1, j + 1) * fx;
    return top * (1 - fy) + bottom * fy;
  }

 private:
  static double smooth(double t) { return t * t * (3 - 2 * t); }
  double value(int i, int j) const {
    const auto wrap = [](int k, int count) { return static_cast<std::uint64_t>(((k % count) + count) % count); };
    return unit_interval(hash_bits(seed_, wrap(i, columns_), wrap(j, rows_)));
  }

  std::uint64_t seed_;
  int columns_;
  int rows_;
};

Rgb random_color(Random& random, double saturation) {
  const auto channel = [&] { return static_cast<std::uint8_t>(255 * (1 - saturation * random.uniform())); };
  const std::uint8_t r = channel();
  const std::uint8_t g = channel();
  return {r, g, channel()};
}

Image<Rgb> paint_landscape(std::uint64_t seed) {
  Random random(seed);
  const Rgb sky = mixed({120, 170, 225}, {250, 170, 110}, random.uniform());
  const Rgb land = mixed({70, 120, 60}, {150, 120, 70}, random.uniform());
  const Noise hills(seed, 5, 1);
  const Noise detail(seed + 1, 32, 32);
  const double sun_u = random.uniform(0.2, 0.8);
  return painted(160, 120, [&](double u, double v) {
    if (std::hypot((u - sun_u) * 1.33, v - 0.22) < 0.07) return Rgb{255, 240, 190};
    if (v < 0.35 + 0.25 * hills(u, 0)) return mixed(sky, {255, 255, 255}, v);
    if (v < 0.55 + 0.25 * hills(u + 0.4, 0)) return mixed(land, sky, 0.45);
    return shaded(land, 0.6 + 0.6 * detail(u, v));
  });
}

Image<Rgb> paint_blocks(std::uint64_t seed) {
  Random random(seed);
  const std::array<Rgb, 5> colors = {{{200, 40, 35}, {30, 70, 160}, {235, 200, 60}, {240, 238, 230}, {240, 238, 230}}};
  const std::array<double, 3> columns = {random.uniform(0.15, 0.4), random.uniform(0.5, 0.85), 1};
  const std::array<double, 3> rows = {random.uniform(0.15, 0.4), random.uniform(0.5, 0.85), 1};
  std::array<Rgb, 9> fill;
  for (Rgb& color : fill) color = colors[random.index(colors.size())];
  return painted(120, 120, [&](double u, double v) {
    const auto cell = [](const std::array<double, 3>& edges, double t) { return t < edges[0] ? 0U : t < edges[1] ? 1U : 2U; };
    const auto on_line = [](const std::array<double, 3>& edges, double t) {
      return std::abs(t - edges[0]) < 0.015 || std::abs(t - edges[1]) < 0.015;
    };
    if (on_line(columns, u) || on_line(rows, v)) return Rgb{20, 20, 20};
    return fill[3 * cell(rows, v) + cell(columns, u)];
  });
}

Image<Rgb> paint_discs(std::uint64_t seed) {
  struct Disc {
    double u, v, radius;
    Rgb color;
  };
  Random random(seed);
  const Rgb ground = random_color(random, 0.35);
  std::vector<Disc> discs;
  for (int i = 0; i < 9; ++i) {
    Disc disc{random.uniform(), random.uniform(), random.uniform(0.06, 0.25), {}};
    disc.color = random_color(random, 0.95);
    discs.push_back(disc);
  }
  return painted(128, 128, [&](double u, double v) {
    Rgb color = ground;
    for (const Disc& disc : discs) {
      if (std::hypot(u - disc.u, v - disc.v) < disc.radius) color = mixed(color, disc.color, 0.8);
    }
    return color;
  });
}

Image<Rgb> paint_waves(std::uint64_t seed) {
  Random random(seed);
  const Rgb top = random_color(random, 0.5);
  const Rgb low = random_color(random, 0.95);
  const double turns = random.integer(2, 5);
  const Noise noise(seed, 4, 4);
  return painted(128, 128, [&](double u, double v) {
    const double band = std::sin(2 * kPi * (turns * v + 1.5 * noise(u, v)));
    return mixed(top, low, 0.5 + 0.5 * band);
  });
}

}  // namespace

Image<Rgb> paint_wood(Rgb color, std::uint64_t seed) {
  const Noise broad(seed, 6, 2);
  const Noise fine(seed + 1, 64, 4);
  return painted(128, 128, [&](double u, double v) {
    const double rings = 0.5 + 0.5 * std::sin(2 * kPi * (4 * u + 1.5 * broad(u, v)));
    return shaded(color, 0.82 + 0.14 * rings + 0.14 * fine(u, v));
  });
}

Image<Rgb> paint_cloth(Rgb color, int variant) {
  const Noise weave(static_cast<std::uint64_t>(variant), 64, 64);
  const Rgb pale = mixed(color, {255, 255, 255}, 0.6);
  return painted(128, 128, [&](double u, double v) {
    Rgb thread = color;
    if (variant % 4 == 1 && std::fmod(u * 12, 2) < 1) thread = pale;
    if (variant % 4 == 2 && std::hypot(std::fmod(u * 10, 1) - 0.5, std::fmod(v * 14, 1) - 0.5) < 0.28) thread = pale;
    if (variant % 4 == 3 && std::fmod(v * 8, 2) < 0.5) thread = pale;
    return shaded(thread, 0.9 + 0.15 * weave(u, v));
  });
}

Image<Rgb> paint_stone(Rgb color, std::uint64_t seed) {
  const Noise fine(seed, 96, 96);
  const Noise broad(seed + 1, 8, 8);
  return painted(128, 128, [&](double u, double v) { return shaded(color, 0.7 + 0.35 * fine(u, v) + 0.15 * broad(u, v)); });
}

Image<Rgb> paint_picture(int variant) {
  const auto seed = hash_bits(static_cast<std::uint64_t>(variant), 0x7069637475726573U);
  switch (variant % 4) {
    case 0:
      return paint_landscape(seed);
    case 1:
      return paint_blocks(seed);
    case 2:
      return paint_discs(seed);
    default:
      return paint_waves(seed);
  }
}

Image<Rgb> paint_sky(std::uint64_t seed) {
  const Noise clouds(seed, 5, 4);
  const Noise roofs(seed + 1, 9, 1);
  return painted(96, 96, [&](double u, double v) {
    if (v > 0.72 + 0.12 * roofs(u, 0)) return mixed({150, 175, 150}, {225, 235, 240}, 0.5);
    const Rgb blue = mixed({165, 205, 245}, {235, 244, 252}, v);
    return mixed(blue, {255, 255, 255}, 0.7 * clouds(u, v));
  });
}

Image<Rgb> paint_books(std::uint64_t seed, int books) {
  Random random(seed);
  Image<Rgb> image(16 * books, 64);
  for (int book = 0; book < books; ++book) {
    const Rgb color = shaded(random_color(random, 0.85), 0.8);
    const int top = random.integer(0, 18);
    for (int v = 0; v < image.height(); ++v) {
      for (int u = 16 * book; u < 16 * (book + 1); ++u) {
        const bool is_title = v > top + 8 && v < top + 16 && u % 16 > 3 && u % 16 < 12;
        const bool is_gap = u % 16 == 0 || v < top;
        image(u, v) = is_gap ? Rgb{35, 28, 22} : is_title ? mixed(color, {255, 250, 230}, 0.7) : color;
      }
    }
  }
  return image;
}

Image<Rgb> paint_screen(int variant) {
  if (variant % 2 == 0) {
    return painted(64, 36, [](double u, double v) { return shaded({26, 28, 32}, 0.8 + 0.8 * (1 - u) * (1 - v)); });
  }
  return painted(128, 80, [](double u, double v) {
    const bool is_window = u > 0.08 && u < 0.62 && v > 0.1 && v < 0.85;
    if (!is_window) return mixed({40, 90, 160}, {90, 160, 200}, v);
    if (v < 0.16) return Rgb{90, 95, 100};
    const bool is_text = std::fmod(v * 30, 2) < 1 && u < 0.3 + 0.25 * std::abs(std::sin(40 * std::floor(v * 15)));
    return is_text ? Rgb{90, 90, 95} : Rgb{245, 245, 245};
  });
}

}  // namespace panoptic
