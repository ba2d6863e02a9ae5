// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "panoptic/sim/paint.h"
#include "panoptic/sim/parametric_shapes.h"
#include "panoptic/sim/random.h"

namespace panoptic {
namespace {

std::uint64_t seed_of(const ParametricShape& shape) { return static_cast<std::uint64_t>(shape.variant) + 1; }

}  // namespace

void make_bin(const ParametricShape& shape, ModelBuilder& builder) {
  const float r = shape.size_m.x() / 2;
  const float h = shape.size_m.z();
  builder.lathe(Vec3f::Zero(), {{0, 0}, {0.8F * r, 0}, {r, h}, {0.95F * r, h}, {0.78F * r, 0.03F}, {0, 0.03F}},
                builder.material(shape.color));
}

// Boards, and rows of books that fill three quarters of each shelf or more.
void make_bookshelf(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  constexpr float board = 0.02F;
  const auto wood = builder.material(paint_wood(shape.color, seed_of(shape)));
  const float x = size.x() / 2;
  const float y = size.y() / 2;
  builder.box({-x, -y, 0}, {-x + board, y, size.z()}, wood);
  builder.box({x - board, -y, 0}, {x, y, size.z()}, wood);
  builder.box({-x + board, y - 0.01F, 0}, {x - board, y, size.z()}, wood);
  const int shelves = std::max(2, static_cast<int>(std::lround(size.z() / 0.36F)));
  const float pitch = (size.z() - board) / static_cast<float>(shelves);
  Random random(seed_of(shape), 0x626f6f6b73U);
  for (int i = 0; i <= shelves; ++i) {
    const float z = pitch * static_cast<float>(i);
    builder.box({-x + board, -y, z}, {x - board, y - 0.01F, z + board}, wood);
    if (i == shelves) continue;
    const float right = -x + board + (2 * (x - board)) * static_cast<float>(random.uniform(0.75, 1));
    const float top = z + board + 0.75F * (pitch - board);
    const float front = -y + static_cast<float>(random.uniform(0.02, 0.06));
    const int books = std::max(3, static_cast<int>((right + x) / 0.035F));
    const auto spines = builder.material(paint_books(seed_of(shape) * 64 + static_cast<std::uint64_t>(i), books));
    const auto pages = builder.material(Rgb{225, 215, 190});
    builder.box({-x + board, front + 0.002F, z + board}, {right, y - 0.03F, top - 0.02F}, pages);
    builder.quad({Vec3f(-x + board, front, z + board), Vec3f(right, front, z + board), Vec3f(right, front, top),
                  Vec3f(-x + board, front, top)},
                 spines);
  }
}

// A body on legs or on a plinth, with doors and drawers in front.
void make_sideboard(const ParametricShape& shape, ModelBuilder& builder) {
  constexpr float gap = 0.003F;
  const Vec3f& size = shape.size_m;
  const float x = size.x() / 2;
  const float y = size.y() / 2;
  const bool is_wood = shape.color.r > shape.color.b + 40;  // brown; other colours are lacquer
  const auto body = is_wood ? builder.material(paint_wood(shape.color, seed_of(shape))) : builder.material(shape.color);
  const auto dark = builder.material(Rgb{40, 38, 36});
  const float legs = shape.variant % 2 == 0 ? 0.05F : 0.12F;
  const float front = -y + 0.035F;
  if (shape.variant % 2 == 0) builder.box({-x + 0.02F, front + 0.05F, 0}, {x - 0.02F, y, legs}, dark);
  for (const float side : {-1.0F, 1.0F}) {
    if (shape.variant % 2 == 0) break;
    for (const float depth : {front + 0.05F, y - 0.05F})
      builder.bar({side * (x - 0.05F), depth, 0}, {side * (x - 0.05F), depth, legs}, 0.02F, dark);
  }
  builder.box({-x, front + 0.02F, legs}, {x, y, size.z() - 0.02F}, body);
  builder.box({-x, front, size.z() - 0.02F}, {x, y, size.z()}, body);
  const int columns = std::max(1, static_cast<int>(std::lround(size.x() / 0.5F)));
  const int rows = std::max(1, static_cast<int>(std::lround(size.z() / 0.6F)) + shape.variant % 3);
  const float width = size.x() / static_cast<float>(columns);
  const float height = (size.z() - 0.02F - legs) / static_cast<float>(rows);
  for (int i = 0; i < columns * rows; ++i) {
    const float left = -x + width * static_cast<float>(i % columns);
    const float low = legs + height * static_cast<float>(i / columns);
    builder.box({left + gap, front, low + gap}, {left + width - gap, front + 0.018F, low + height - gap}, body);
    const float middle = left + width / 2;
    const float handle = low + height - std::min(0.06F, height / 2);
    builder.box({middle - 0.06F, front - 0.02F, handle - 0.007F}, {middle + 0.06F, front, handle + 0.007F}, dark);
  }
}

// Foot, pole and a shade.
void make_floor_lamp(const ParametricShape& shape, ModelBuilder& builder) {
  const float r = shape.size_m.x() / 2;
  const float h = shape.size_m.z();
  const float shade = std::min(0.3F, 0.2F * h);
  const auto metal = builder.material(Rgb{70, 68, 66});
  builder.lathe(Vec3f::Zero(), {{0, 0}, {0.7F * r, 0}, {0.7F * r, 0.02F}, {0.02F, 0.035F}}, metal);
  builder.bar({0, 0, 0.03F}, {0, 0, h - 0.5F * shade}, 0.014F, metal);
  const float top = shape.variant % 2 == 0 ? 0.65F * r : r;
  builder.lathe({0, 0, h - shade}, {{r, 0}, {top, shade}, {0, shade}}, builder.material(paint_cloth(shape.color, 0)));
}

// Foot, neck and a flat screen; the rest of the depth is the foot's.
void make_monitor(const ParametricShape& shape, ModelBuilder& builder) {
  const Vec3f& size = shape.size_m;
  const float low = size.z() * 0.22F;
  const float x = size.x() / 2;
  const auto body = builder.material(shape.color);
  builder.box({-x * 0.4F, -size.y() / 2, 0}, {x * 0.4F, size.y() / 2, 0.012F}, body);
  builder.box({-0.025F, 0.02F, 0.012F}, {0.025F, 0.045F, size.z() * 0.6F}, body);
  builder.box({-x, -0.02F, low}, {x, 0.02F, size.z()}, body);
  const float edge = 0.012F;
  const float y = -0.0205F;
  builder.quad({Vec3f(-x + edge, y, low + edge), Vec3f(x - edge, y, low + edge), Vec3f(x - edge, y, size.z() - edge),
                Vec3f(-x + edge, y, size.z() - edge)},
               builder.material(paint_screen(shape.variant)));
}

}  // namespace panoptic
