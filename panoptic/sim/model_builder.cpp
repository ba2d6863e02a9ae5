// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/model_builder.h"

#include <cmath>
#include <numbers>

namespace panoptic {
namespace {

constexpr float kTexture_m = 0.5F;
constexpr int kSegments = 20;
constexpr float kFullTurn = 2 * std::numbers::pi_v<float>;

}  // namespace

std::uint32_t ModelBuilder::material(Rgb color) {
  asset_.materials.push_back({color, -1});
  return static_cast<std::uint32_t>(asset_.materials.size() - 1);
}

std::uint32_t ModelBuilder::material(Image<Rgb> texture) {
  asset_.materials.push_back({{255, 255, 255}, static_cast<std::int32_t>(asset_.textures.size())});
  asset_.textures.push_back(std::move(texture));
  return static_cast<std::uint32_t>(asset_.materials.size() - 1);
}

void ModelBuilder::box(const Vec3f& low, const Vec3f& high, std::uint32_t material) {
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    for (int side = 0; side < 2; ++side) {
      std::array<Vec3f, 4> corners;
      for (std::size_t i = 0; i < 4; ++i) {
        const bool far_a = (i == 1 || i == 2) == (side == 1);  // turns the face over, so that it looks outwards
        corners[i][axis] = side == 0 ? low[axis] : high[axis];
        corners[i][a] = far_a ? high[a] : low[a];
        corners[i][b] = i >= 2 ? high[b] : low[b];
      }
      const std::size_t first = asset_.model.positions.size();
      quad(corners, material);
      for (std::size_t i = 0; i < 4; ++i) {
        const Vec3f& p = corners[i];
        const Eigen::Vector2f across = axis == 0 ? p.tail<2>() : Eigen::Vector2f(p.x(), axis == 1 ? p.z() : p.y());
        asset_.model.uvs[first + i] = across / kTexture_m;
      }
    }
  }
}

void ModelBuilder::quad(const std::array<Vec3f, 4>& corners, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(asset_.model.positions.size());
  asset_.model.positions.insert(asset_.model.positions.end(), corners.begin(), corners.end());
  for (const auto& uv : {std::pair(0, 1), {1, 1}, {1, 0}, {0, 0}}) asset_.model.uvs.emplace_back(uv.first, uv.second);
  asset_.model.triangles.push_back({first, first + 1, first + 2});
  asset_.model.triangles.push_back({first, first + 2, first + 3});
  asset_.model.material_of.insert(asset_.model.material_of.end(), 2, material);
}

void ModelBuilder::sheet(const Grid& grid, const std::function<Vec3f(float, float)>& at, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(asset_.model.positions.size());
  for (int row = 0; row <= grid.rows; ++row) {
    for (int column = 0; column <= grid.columns; ++column) {
      const float u = static_cast<float>(column) / static_cast<float>(grid.columns);
      const float v = static_cast<float>(row) / static_cast<float>(grid.rows);
      asset_.model.positions.push_back(at(u, v));
      asset_.model.uvs.emplace_back(u, 1 - v);
    }
  }
  const auto stride = static_cast<std::uint32_t>(grid.columns + 1);
  for (std::uint32_t row = 0; row + 1 <= static_cast<std::uint32_t>(grid.rows); ++row) {
    for (std::uint32_t column = 0; column + 1 < stride; ++column) {
      const std::uint32_t i = first + row * stride + column;
      asset_.model.triangles.push_back({i, i + 1, i + 1 + stride});
      asset_.model.triangles.push_back({i, i + 1 + stride, i + stride});
      asset_.model.material_of.insert(asset_.model.material_of.end(), 2, material);
    }
  }
}

void ModelBuilder::lathe(const Vec3f& center, const std::vector<std::pair<float, float>>& profile, std::uint32_t material) {
  const auto last = static_cast<float>(profile.size() - 1);
  const auto at = [&](float u, float v) {
    const auto& [radius, height] = profile[static_cast<std::size_t>(std::lround(v * last))];
    return Vec3f(center + Vec3f(radius * std::cos(u * kFullTurn), radius * std::sin(u * kFullTurn), height));
  };
  sheet({kSegments, static_cast<int>(profile.size()) - 1}, at, material);
}

void ModelBuilder::bar(const Vec3f& from, const Vec3f& to, float radius, std::uint32_t material) {
  const Vec3f along = (to - from).normalized();
  const Vec3f side = along.unitOrthogonal() * radius;
  const Vec3f other = along.cross(side);
  const auto at = [&](float u, float v) {
    return Vec3f(from + v * (to - from) + std::cos(u * kFullTurn) * side + std::sin(u * kFullTurn) * other);
  };
  sheet({8, 1}, at, material);
}

}  // namespace panoptic
