// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "panoptic/sim/paint.h"
#include "panoptic/sim/parametric_shapes.h"

namespace panoptic {
namespace {

constexpr Rgb kMetal{165, 168, 172};

std::uint64_t seed_of(const ParametricShape& shape) { return static_cast<std::uint64_t>(shape.variant) + 1; }

Rgb darker(Rgb color) {
  const auto channel = [](std::uint8_t value) { return static_cast<std::uint8_t>(value * 17 / 20); };
  return {channel(color.r), channel(color.g), channel(color.b)};
}

// Four boards around the rectangle in the plane of the wall.
void add_frame(ModelBuilder& builder, const Eigen::AlignedBox3f& outside, float board_m, std::uint32_t material) {
  const Vec3f& low = outside.min();
  const Vec3f& high = outside.max();
  builder.box(low, {low.x() + board_m, high.y(), high.z()}, material);
  builder.box({high.x() - board_m, low.y(), low.z()}, high, material);
  builder.box({low.x() + board_m, low.y(), low.z()}, {high.x() - board_m, high.y(), low.z() + board_m}, material);
  builder.box({low.x() + board_m, low.y(), high.z() - board_m}, {high.x() - board_m, high.y(), high.z()}, material);
}

Eigen::AlignedBox3f box_of(const Vec3f& size) {
  return {Vec3f(-size.x() / 2, -size.y() / 2, 0), Vec3f(size.x() / 2, size.y() / 2, size.z())};
}

}  // namespace

// A sheet in folds that widen downwards, on a rod.
void make_curtain(const ParametricShape& shape, ModelBuilder& builder) {
  const float w = shape.size_m.x();
  const float d = shape.size_m.y();
  const float rod = std::min(0.012F, d / 4);
  const float top = shape.size_m.z() - 2 * rod;
  const float folds = std::max(2.0F, std::round(w / 0.16F));
  const auto at = [&](float u, float v) {
    const float depth = (0.5F - 0.2F * v) * d;
    const float phase = folds * u + 0.15F * std::sin(5.0F * u + 2.0F * (1 - v));
    return Vec3f((u - 0.5F) * w * 0.97F, depth * std::sin(2 * std::numbers::pi_v<float> * phase), v * top);
  };
  builder.sheet({static_cast<int>(folds) * 12, 6}, at, builder.material(paint_cloth(shape.color, shape.variant)));
  builder.bar({-w / 2, 0, top + rod}, {w / 2, 0, top + rod}, rod, builder.material(kMetal));
}

// A leaf with raised panels and a handle on both faces.
void make_door(const ParametricShape& shape, ModelBuilder& builder) {
  constexpr float handle_m = 0.045F;  // how far it stands out
  const Vec3f& size = shape.size_m;
  const float leaf = std::max(0.03F, size.y() / 2 - handle_m);
  const bool is_wood = shape.variant % 2 == 1;
  const auto surface = [&](Rgb color) {
    return is_wood ? builder.material(paint_wood(color, seed_of(shape))) : builder.material(color);
  };
  const auto wood = surface(shape.color);
  const auto panel = surface(darker(shape.color));
  const auto metal = builder.material(kMetal);
  builder.box({-size.x() / 2, -leaf, 0}, {size.x() / 2, leaf, size.z()}, wood);
  const int panels = shape.variant % 3 == 2 ? 0 : 2 + shape.variant % 2;
  const float edge = 0.12F;
  const float height = (size.z() - edge * static_cast<float>(panels + 1)) / static_cast<float>(std::max(1, panels));
  for (int i = 0; i < panels; ++i) {
    const float low = edge + static_cast<float>(i) * (height + edge);
    builder.box({-size.x() / 2 + edge, -leaf - 0.008F, low}, {size.x() / 2 - edge, leaf + 0.008F, low + height}, panel);
  }
  const float x = size.x() / 2 - 0.07F;
  const float z = std::min(1.02F, size.z() / 2);
  for (const float side : {-1.0F, 1.0F}) {
    const float y = side * (size.y() / 2 - 0.01F);
    builder.bar({x, side * leaf, z}, {x, y, z}, 0.01F, metal);
    builder.box({x - 0.13F, std::min(y - 0.01F, y + 0.01F), z - 0.012F}, {x + 0.012F, y + 0.01F, z + 0.012F}, metal);
  }
}

void make_picture(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  const float board = std::min(0.035F, size.x() / 8);
  add_frame(builder, box_of(size), board, builder.material(paint_wood(shape.color, seed_of(shape))));
  const float x = size.x() / 2 - board;
  const float z = size.z() - board;
  const float y = -size.y() / 4;
  builder.quad({Vec3f(-x, y, board), Vec3f(x, y, board), Vec3f(x, y, z), Vec3f(-x, y, z)},
               builder.material(paint_picture(shape.variant)));
  const float back = size.y() / 2;
  builder.quad({Vec3f(x, back, board), Vec3f(-x, back, board), Vec3f(-x, back, z), Vec3f(x, back, z)},
               builder.material(Rgb{120, 100, 80}));
}

// Frame, mullions and one opaque pane that shows a bright sky: a depth image needs a surface there.
void make_window(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  const float board = 0.06F;
  const auto frame = builder.material(shape.color);
  add_frame(builder, box_of(size), board, frame);
  const int sashes = std::max(1, static_cast<int>(std::lround(size.x() / 0.7F)));
  for (int i = 1; i < sashes; ++i) {
    const float x = -size.x() / 2 + size.x() * static_cast<float>(i) / static_cast<float>(sashes);
    builder.box({x - 0.04F, -size.y() / 3, board}, {x + 0.04F, size.y() / 3, size.z() - board}, frame);
  }
  if (shape.variant % 2 == 1) {
    const float z = size.z() * 0.62F;
    builder.box({-size.x() / 2 + board, -size.y() / 4, z - 0.02F}, {size.x() / 2 - board, size.y() / 4, z + 0.02F}, frame);
  }
  const float x = size.x() / 2 - board;
  const float z = size.z() - board;
  builder.quad({Vec3f(-x, 0, board), Vec3f(x, 0, board), Vec3f(x, 0, z), Vec3f(-x, 0, z)},
               builder.material(paint_sky(seed_of(shape))));
}

}  // namespace panoptic
