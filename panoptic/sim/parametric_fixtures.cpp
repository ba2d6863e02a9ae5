// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "panoptic/sim/paint.h"
#include "panoptic/sim/parametric_shapes.h"

namespace panoptic {
namespace {

constexpr Rgb kMetal{170, 173, 178};
constexpr Rgb kDark{35, 36, 40};
constexpr float kFullTurn = 2 * std::numbers::pi_v<float>;

std::uint64_t seed_of(const ParametricShape& shape) { return static_cast<std::uint64_t>(shape.variant) + 1; }

// A rounded rectangle through (1, 0), (0, 1), ... scaled by the half sides: a superellipse.
Eigen::Vector2f rounded(float u, float half_x, float half_y) {
  const float c = std::cos(u * kFullTurn);
  const float s = std::sin(u * kFullTurn);
  const auto root = [](float t) { return std::copysign(std::pow(std::abs(t), 0.4F), t); };
  return {half_x * root(c), half_y * root(s)};
}

struct Rim {
  float x = 0;  // half sides
  float y = 0;
  float z = 0;
};

// A vessel: one sheet through the rims, closed at the last one.
void add_vessel(ModelBuilder& builder, const std::vector<Rim>& rims, std::uint32_t material) {
  const auto last = static_cast<float>(rims.size() - 1);
  const auto at = [&](float u, float v) {
    const Rim& rim = rims[static_cast<std::size_t>(std::lround(v * last))];
    const Eigen::Vector2f p = rounded(u, rim.x, rim.y);
    return Vec3f(p.x(), p.y(), rim.z);
  };
  builder.sheet({32, static_cast<int>(rims.size()) - 1}, at, material);
}

// Outside, rim and inside of a tub whose walls are `wall` thick.
std::vector<Rim> tub(const Vec3f& size, float wall) {
  const float x = size.x() / 2;
  const float y = size.y() / 2;
  const float floor = std::max(0.03F, 0.2F * size.z());
  return {{0, 0, 0},
          {x * 0.94F, y * 0.94F, 0},
          {x, y, size.z()},
          {x - wall, y - wall, size.z()},
          {(x - wall) * 0.85F, (y - wall) * 0.8F, floor},
          {0, 0, floor}};
}

void add_tap(ModelBuilder& builder, const Vec3f& foot, float height, float reach) {
  const auto metal = builder.material(kMetal);
  const Vec3f top = foot + Vec3f(0, 0, height);
  builder.bar(foot, top, 0.014F, metal);
  builder.bar(top, top + Vec3f(0, -reach, -0.01F), 0.012F, metal);
}

void add_front(ModelBuilder& builder, const Eigen::AlignedBox2f& front, float y, std::uint32_t material) {
  constexpr float gap = 0.004F;
  const auto metal = builder.material(kMetal);
  builder.box({front.min().x() + gap, y, front.min().y() + gap}, {front.max().x() - gap, y + 0.02F, front.max().y() - gap},
              material);
  const float x = front.center().x();
  const float z = front.max().y() - 0.06F;
  builder.box({x - 0.07F, y - 0.02F, z - 0.008F}, {x + 0.07F, y, z + 0.008F}, metal);
}

}  // namespace

// A bowl that stands on a counter, with a tap behind it.
void make_basin(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f bowl(shape.size_m.x(), shape.size_m.y(), shape.size_m.z() * 0.5F);
  add_vessel(builder, tub(bowl, 0.025F), builder.material(shape.color));
  add_tap(builder, {0, shape.size_m.y() / 2 - 0.015F, bowl.z() * 0.8F}, shape.size_m.z() - bowl.z() * 0.8F - 0.012F,
          shape.size_m.y() * 0.4F);
}

void make_bathtub(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  const float rim = size.z() * 0.85F;  // the tap stands above it
  const auto enamel = builder.material(shape.color);
  if (shape.variant % 2 == 0) {
    const auto apron = builder.material(paint_stone({225, 225, 222}, seed_of(shape)));
    for (const float side : {-1.0F, 1.0F}) {
      const float y = side * (size.y() / 2 - 0.01F);
      const float x = side * (size.x() / 2 - 0.01F);
      builder.box({-size.x() / 2, y - 0.01F, 0}, {size.x() / 2, y + 0.01F, rim - 0.03F}, apron);
      builder.box({x - 0.01F, -size.y() / 2, 0}, {x + 0.01F, size.y() / 2, rim - 0.03F}, apron);
    }
  }
  add_vessel(builder, tub({size.x(), size.y(), rim}, 0.06F), enamel);
  add_tap(builder, {0, size.y() / 2 - 0.03F, rim}, size.z() - rim - 0.012F, 0.12F);
}

// Plinth, carcass, fronts, and a worktop that stands out over them.
void make_counter(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  constexpr float top_m = 0.04F;
  constexpr float plinth_m = 0.1F;
  const float front = -size.y() / 2 + 0.045F;
  const auto fronts =
      shape.variant % 2 == 1 ? builder.material(paint_wood(shape.color, seed_of(shape))) : builder.material(shape.color);
  const auto worktop =
      builder.material(paint_stone(shape.variant % 3 == 0 ? Rgb{95, 92, 90} : Rgb{205, 195, 180}, seed_of(shape)));
  builder.box({-size.x() / 2, front + 0.05F, 0}, {size.x() / 2, size.y() / 2, plinth_m}, builder.material(kDark));
  builder.box({-size.x() / 2, front + 0.02F, plinth_m}, {size.x() / 2, size.y() / 2, size.z() - top_m}, fronts);
  const int units = std::max(1, static_cast<int>(std::lround(size.x() / 0.5F)));
  const float width = size.x() / static_cast<float>(units);
  for (int i = 0; i < units; ++i) {
    const float left = -size.x() / 2 + static_cast<float>(i) * width;
    const float drawer = size.z() - top_m - 0.2F;
    const bool has_drawer = (i + shape.variant) % 2 == 0;
    if (has_drawer)
      add_front(builder, {Eigen::Vector2f(left, drawer), Eigen::Vector2f(left + width, size.z() - top_m)}, front, fronts);
    const float top = has_drawer ? drawer : size.z() - top_m;
    add_front(builder, {Eigen::Vector2f(left, plinth_m), Eigen::Vector2f(left + width, top)}, front, fronts);
  }
  builder.box({-size.x() / 2, -size.y() / 2, size.z() - top_m}, {size.x() / 2, size.y() / 2, size.z()}, worktop);
}

void make_radiator(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  const auto paint = builder.material(shape.color);
  const int ribs = std::max(3, static_cast<int>(std::lround(size.x() / 0.07F)));
  const float pitch = size.x() / static_cast<float>(ribs);
  for (int i = 0; i < ribs; ++i) {
    const float left = -size.x() / 2 + pitch * static_cast<float>(i);
    builder.box({left, -size.y() / 2, 0}, {left + pitch * 0.72F, size.y() / 2, size.z()}, paint);
  }
  const float back = size.y() / 4;
  builder.box({-size.x() / 2, -back, 0.03F}, {size.x() / 2, back, size.z() - 0.03F}, paint);
}

// Two doors, one above the other.
void make_refrigerator(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  const auto paint = builder.material(shape.color);
  const auto metal = builder.material(kMetal);
  const float front = -size.y() / 2 + 0.035F;
  const float split = size.z() * (shape.variant % 2 == 0 ? 0.36F : 0.7F);
  builder.box({-size.x() / 2, front + 0.06F, 0}, {size.x() / 2, size.y() / 2, size.z()}, paint);
  const float hinge = size.x() / 2 - 0.05F;
  for (const auto& [low, high] : {std::pair(0.05F, split - 0.005F), std::pair(split + 0.005F, size.z())}) {
    builder.box({-size.x() / 2, front, low}, {size.x() / 2, front + 0.055F, high}, paint);
    const float middle = low < split && high < split ? high - 0.22F : low + 0.22F;
    builder.box({hinge - 0.012F, front - 0.035F, middle - 0.16F}, {hinge + 0.012F, front, middle + 0.16F}, metal);
  }
}

// Oven door with a window, knobs, and four plates.
void make_stove(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  const auto body = builder.material(shape.color);
  const auto dark = builder.material(kDark);
  const auto metal = builder.material(kMetal);
  const float front = -size.y() / 2 + 0.04F;
  const float top = size.z() - 0.02F;
  builder.box({-size.x() / 2, front, 0}, {size.x() / 2, size.y() / 2, top}, body);
  builder.box({-size.x() / 2, front, top}, {size.x() / 2, size.y() / 2, size.z() - 0.01F}, dark);
  const float half = size.x() / 2 - 0.08F;
  builder.box({-half, front - 0.008F, 0.28F * size.z()}, {half, front, 0.66F * size.z()}, dark);
  builder.box({-half, front - 0.04F, 0.72F * size.z()}, {half, front - 0.025F, 0.745F * size.z()}, metal);
  for (int i = 0; i < 5; ++i) {
    const float x = half * (static_cast<float>(i) / 2 - 1);
    const Vec3f knob(x, front, 0.87F * size.z());
    builder.bar(knob, knob - Vec3f(0, 0.03F, 0), 0.02F, metal);
  }
  for (const float x : {-0.24F, 0.24F}) {
    for (const float y : {-0.2F, 0.24F}) {
      const float radius = (x * y > 0 ? 0.13F : 0.16F) * size.x();
      builder.lathe({x * size.x(), y * size.y(), size.z() - 0.012F}, {{radius, 0}, {radius, 0.012F}, {0, 0.012F}}, metal);
    }
  }
}

}  // namespace panoptic
