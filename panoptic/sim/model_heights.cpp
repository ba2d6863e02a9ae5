// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/model_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace panoptic {
namespace {

constexpr double kModelCell_m = 0.01;
constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

// Raises the cells whose middle the triangle covers.
void add_triangle(const std::array<Vec3d, 3>& corner, ModelHeights& heights) {
  const FlatGrid& grid = heights.grid;
  std::array<Vec2d, 3> flat;
  Eigen::AlignedBox2d around;
  for (std::size_t i = 0; i < 3; ++i) {
    flat[i] = (corner[i].head<2>() - grid.origin) / grid.cell_m;
    around.extend(flat[i]);
  }
  const double area = cross(flat[1] - flat[0], flat[2] - flat[0]);
  if (std::abs(area) < 1e-9) return;
  for (int y = std::max(0, static_cast<int>(around.min().y()));
       y <= std::min(grid.height - 1, static_cast<int>(around.max().y())); ++y) {
    for (int x = std::max(0, static_cast<int>(around.min().x()));
         x <= std::min(grid.width - 1, static_cast<int>(around.max().x())); ++x) {
      const Vec2d at(x + 0.5, y + 0.5);
      const double b = cross(at - flat[0], flat[2] - flat[0]) / area;
      const double c = cross(flat[1] - flat[0], at - flat[0]) / area;
      if (b < -1e-9 || c < -1e-9 || b + c > 1 + 1e-9) continue;
      const auto z =
          static_cast<float>(corner[0].z() + b * (corner[1].z() - corner[0].z()) + c * (corner[2].z() - corner[0].z()));
      float& top = heights.top_m[grid.number(x, y)];
      if (!(top >= z)) top = z;
    }
  }
}

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Parts of the range's cells; where the surface is steep, one ends.
CellParts gentle_parts(const ModelHeights& heights, const HeightRange& range) {
  constexpr double kSteep = 0.84;  // the tangent of 40 degrees
  const FlatGrid& grid = heights.grid;
  CellSet gentle(grid.size(), 0);
  for (int y = 1; y + 1 < grid.height; ++y) {
    for (int x = 1; x + 1 < grid.width; ++x) {
      const float top = heights.top_m[grid.number(x, y)];
      if (!(top >= range.low_m && top <= range.high_m)) continue;
      const float dx = heights.top_m[grid.number(x + 1, y)] - heights.top_m[grid.number(x - 1, y)];
      const float dy = heights.top_m[grid.number(x, y + 1)] - heights.top_m[grid.number(x, y - 1)];
      // At an edge there is nothing beyond: the cell belongs to the part that ends there.
      const double slope = std::hypot(std::isnan(dx) ? 0 : dx, std::isnan(dy) ? 0 : dy) / (2 * grid.cell_m);
      if (slope <= kSteep) gentle[grid.number(x, y)] = 1;
    }
  }
  return connected_parts(grid, gentle);
}

}  // namespace

ModelHeights model_heights(const Scene& scene, const SceneObject& object) {
  const SceneModel& model = scene.models[object.model];
  const double bottom_m = object.world_from_object.translation().z();
  const auto corner = [&](std::uint32_t i) -> Vec3d {
    Vec3d at = model.positions[i].cwiseProduct(object.scale).cast<double>();
    at.z() += bottom_m;
    return at;
  };
  Eigen::AlignedBox2d area;
  for (std::uint32_t i = 0; i < model.positions.size(); ++i) area.extend(corner(i).head<2>());
  ModelHeights heights{grid_over(area, kModelCell_m, 2), {}};
  heights.top_m.assign(heights.grid.size(), kNothing);
  for (const auto& [a, b, c] : model.triangles) add_triangle({corner(a), corner(b), corner(c)}, heights);
  return heights;
}

std::optional<LevelPart> level_part(const ModelHeights& heights, const HeightRange& range, double least_m2) {
  constexpr float kLevel_m = 0.05F;
  const CellParts parts = gentle_parts(heights, range);
  const int count = parts.empty() ? 0 : *std::max_element(parts.begin(), parts.end());
  std::vector<std::vector<float>> tops(static_cast<std::size_t>(count) + 1);
  for (std::size_t cell = 0; cell < parts.size(); ++cell) {
    if (parts[cell] > 0) tops[static_cast<std::size_t>(parts[cell])].push_back(heights.top_m[cell]);
  }
  const auto largest =
      std::max_element(tops.begin(), tops.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  if (largest->empty()) return std::nullopt;
  LevelPart result;
  result.height_m = median(*largest);
  result.cells.assign(heights.grid.size(), 0);
  std::vector<char> is_level(tops.size(), 0);
  for (std::size_t part = 1; part < tops.size(); ++part) {
    is_level[part] = std::abs(median(tops[part]) - static_cast<float>(result.height_m)) <= kLevel_m ? 1 : 0;
  }
  for (std::size_t cell = 0; cell < parts.size(); ++cell) {
    if (parts[cell] == 0 || is_level[static_cast<std::size_t>(parts[cell])] == 0) continue;
    result.cells[cell] = 1;
    result.area_m2 += heights.grid.cell_m * heights.grid.cell_m;
  }
  if (result.area_m2 < least_m2) return std::nullopt;
  return result;
}

Polygon shape_of(const FlatGrid& grid, const CellSet& cells) {
  constexpr double kFull = 0.9;
  std::vector<Vec2d> at;
  double area_m2 = 0;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    if (cells[cell] == 0) continue;
    area_m2 += grid.cell_m * grid.cell_m;
    const FlatBox square{grid.middle(cell), Vec2d::UnitX(), Vec2d::Constant(grid.cell_m)};
    for (const Vec2d& corner : corners(square)) at.push_back(corner);
  }
  const Polygon hull = convex_hull(std::move(at));
  if (area_m2 >= kFull * signed_area(hull)) return simplified(hull, grid.cell_m);
  return simplified(outline(grid, CellParts(cells.begin(), cells.end()), 1), 2 * grid.cell_m);
}

}  // namespace panoptic
