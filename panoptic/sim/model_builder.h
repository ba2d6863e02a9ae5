// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Puts a model together from simple bodies.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "panoptic/sim/model_asset.h"

namespace panoptic {

class ModelBuilder {
 public:
  // The number to give to the functions below.
  std::uint32_t material(Rgb color);
  std::uint32_t material(Image<Rgb> texture);

  // Adds a box. Texture coordinates are in units of 0.5 m, so that wood looks the same on large and small boards.
  void box(const Vec3f& low, const Vec3f& high, std::uint32_t material);

  // Adds a quad with the texture once over all of it: bottom left, bottom right, top right, top left as seen from the front.
  void quad(const std::array<Vec3f, 4>& corners, std::uint32_t material);

  struct Grid {
    int columns = 1;
    int rows = 1;
  };
  // Adds a curved sheet: at(u, v) with u, v in 0..1, v upwards; the texture once over it.
  void sheet(const Grid& grid, const std::function<Vec3f(float, float)>& at, std::uint32_t material);

  // Adds a body of revolution about the vertical axis through `center`: (radius, height above the centre) from bottom to top.
  void lathe(const Vec3f& center, const std::vector<std::pair<float, float>>& profile, std::uint32_t material);

  // Adds a round bar.
  void bar(const Vec3f& from, const Vec3f& to, float radius, std::uint32_t material);

  ModelAsset take() { return std::move(asset_); }

 private:
  ModelAsset asset_;
};

}  // namespace panoptic
