// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/level_patch.h"

#include <algorithm>
#include <cmath>

#include "panoptic/base/flat_grid.h"

namespace panoptic {
namespace {

constexpr double kGentleCosine = 0.77;  // 40 degrees
constexpr double kSameLevel_m = 0.05;

// The highest gentle surface per cell of two voxels.
struct TopLayer {
  FlatGrid grid;
  std::vector<std::vector<const LabelledPoint*>> points;  // per cell, near the highest
  CellSet filled;
};

TopLayer top_layer(const std::vector<LabelledPoint>& points, const HeightSpan& band, double voxel_m) {
  const auto counts = [&](const LabelledPoint& p) {
    return p.at.z() >= band.low_m && p.at.z() <= band.high_m && p.normal.z() >= kGentleCosine;
  };
  Eigen::AlignedBox2d area;
  for (const LabelledPoint& p : points) {
    if (counts(p)) area.extend(p.at.head<2>());
  }
  TopLayer layer{grid_over(area, 2 * voxel_m, 1), {}, {}};
  layer.points.resize(layer.grid.size());
  layer.filled.assign(layer.grid.size(), 0);
  std::vector<double> highest(layer.grid.size(), band.low_m);
  for (const LabelledPoint& p : points) {
    if (!counts(p)) continue;
    const std::size_t cell = layer.grid.cell_at(p.at.head<2>()).value_or(0);
    highest[cell] = std::max(highest[cell], p.at.z());
  }
  for (const LabelledPoint& p : points) {
    if (!counts(p)) continue;
    const std::size_t cell = layer.grid.cell_at(p.at.head<2>()).value_or(0);
    if (p.at.z() < highest[cell] - kSameLevel_m) continue;
    layer.points[cell].push_back(&p);
    layer.filled[cell] = 1;
  }
  return layer;
}

double mean_height(const std::vector<const LabelledPoint*>& points) {
  double sum = 0;
  for (const LabelledPoint* p : points) sum += p->at.z();
  return sum / static_cast<double>(points.size());
}

// Connected parts of the layer in which neighbouring cells differ by no more than a slope of 40 degrees makes.
CellParts gentle_parts_of(const TopLayer& layer) {
  const double step_m = 0.84 * layer.grid.cell_m;
  std::vector<double> height(layer.grid.size(), 0);
  for (std::size_t cell = 0; cell < height.size(); ++cell) {
    if (layer.filled[cell] != 0) height[cell] = mean_height(layer.points[cell]);
  }
  CellParts parts(layer.grid.size(), 0);
  int count = 0;
  for (std::size_t start = 0; start < parts.size(); ++start) {
    if (layer.filled[start] == 0 || parts[start] != 0) continue;
    parts[start] = ++count;
    std::vector<std::size_t> front = {start};
    for (std::size_t i = 0; i < front.size(); ++i) {
      const int x = static_cast<int>(front[i] % static_cast<std::size_t>(layer.grid.width));
      const int y = static_cast<int>(front[i] / static_cast<std::size_t>(layer.grid.width));
      for (int n = 0; n < 9; ++n) {
        const int nx = x + n % 3 - 1;
        const int ny = y + n / 3 - 1;
        if (!layer.grid.holds(nx, ny)) continue;
        const std::size_t next = layer.grid.number(nx, ny);
        if (layer.filled[next] == 0 || parts[next] != 0 || std::abs(height[next] - height[front[i]]) > step_m) continue;
        parts[next] = count;
        front.push_back(next);
      }
    }
  }
  return parts;
}

struct PartMeasure {
  double area_m2 = 0;
  double height_sum = 0;  // times area
};

}  // namespace

std::optional<LevelPatch> level_patch(const std::vector<LabelledPoint>& points, const HeightSpan& band, double voxel_m,
                                      double least_m2) {
  const TopLayer layer = top_layer(points, band, voxel_m);
  const CellParts parts = gentle_parts_of(layer);
  std::vector<PartMeasure> measures(1 + static_cast<std::size_t>(*std::max_element(parts.begin(), parts.end())));
  for (std::size_t cell = 0; cell < parts.size(); ++cell) {
    for (const LabelledPoint* p : layer.points[cell]) {
      PartMeasure& measure = measures[static_cast<std::size_t>(parts[cell])];
      measure.area_m2 += p->area_m2;
      measure.height_sum += p->area_m2 * p->at.z();
    }
  }
  const auto largest = std::max_element(measures.begin(), measures.end(),
                                        [](const PartMeasure& a, const PartMeasure& b) { return a.area_m2 < b.area_m2; });
  if (largest->area_m2 <= 0) return std::nullopt;
  const double level_m = largest->height_sum / largest->area_m2;
  LevelPatch patch;
  patch.normal = Vec3d::Zero();
  std::vector<double> heights;
  for (std::size_t cell = 0; cell < parts.size(); ++cell) {
    const PartMeasure& measure = measures[static_cast<std::size_t>(parts[cell])];
    if (parts[cell] == 0 || std::abs(measure.height_sum / measure.area_m2 - level_m) > kSameLevel_m) continue;
    for (const LabelledPoint* p : layer.points[cell]) {
      patch.points.push_back(p->at);
      patch.normal += p->area_m2 * p->normal;
      patch.center += p->area_m2 * p->at;
      patch.area_m2 += p->area_m2;
      heights.push_back(p->at.z());
    }
  }
  if (patch.area_m2 < least_m2) return std::nullopt;
  patch.center /= patch.area_m2;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  patch.center.z() = *middle;
  patch.normal.normalize();
  return patch;
}

}  // namespace panoptic
