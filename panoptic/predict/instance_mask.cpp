// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/instance_mask.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace panoptic {
namespace {

// The place of pixel i on the grid along one axis.
double on_grid(double i, double cells_per_px, int cells) {
  return std::clamp((i + 0.5) * cells_per_px - 0.5, 0.0, static_cast<double>(cells - 1));
}

// The two cells of a window that a pixel lies between along one axis.
struct Between {
  std::size_t first = 0;
  std::size_t second = 0;
  float share = 0;  // of the second
};

Between between(double position, int window_start, int window_length) {
  const double inside = position - window_start;
  const int first = static_cast<int>(inside);
  return {static_cast<std::size_t>(first), static_cast<std::size_t>(std::min(first + 1, window_length - 1)),
          static_cast<float>(inside - first)};
}

float mix(float a, float b, float share_of_b) { return a + share_of_b * (b - a); }

}  // namespace

double Box::area() const { return std::max(0.0, right - left) * std::max(0.0, bottom - top); }

double intersection_over_union(const Box& a, const Box& b) {
  const Box common{std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right), std::min(a.bottom, b.bottom)};
  const double joint = a.area() + b.area() - common.area();
  return joint > 0 ? common.area() / joint : 0;
}

PixelRect pixels_in(const Box& box, int image_width, int image_height) {
  const auto first_at = [](double edge, int size) {
    return static_cast<int>(std::clamp(std::ceil(edge - 0.5), 0.0, static_cast<double>(size)));
  };
  const int x0 = first_at(box.left, image_width);
  const int y0 = first_at(box.top, image_height);
  return {x0, y0, first_at(box.right, image_width) - x0, first_at(box.bottom, image_height) - y0};
}

ScoreWindow window_around(const PixelRect& rect, const ScoreGrid& grid) {
  const auto column = [&](int u) { return static_cast<int>(on_grid(u - grid.left_px, grid.cells_per_px_x, grid.width)); };
  const auto row = [&](int v) { return static_cast<int>(on_grid(v - grid.top_px, grid.cells_per_px_y, grid.height)); };
  ScoreWindow window{column(rect.x0), row(rect.y0), 0, 0, {}};
  window.width = std::min(column(rect.x0 + rect.width - 1) + 1, grid.width - 1) - window.x0 + 1;
  window.height = std::min(row(rect.y0 + rect.height - 1) + 1, grid.height - 1) - window.y0 + 1;
  return window;
}

Image<std::uint8_t> draw_mask(const PixelRect& rect, const ScoreGrid& grid, const ScoreWindow& window, float threshold) {
  std::vector<Between> columns;
  for (int u = rect.x0; u < rect.x0 + rect.width; ++u) {
    columns.push_back(between(on_grid(u - grid.left_px, grid.cells_per_px_x, grid.width), window.x0, window.width));
  }
  Image<std::uint8_t> mask(rect.width, rect.height);
  for (int v = 0; v < rect.height; ++v) {
    const Between y = between(on_grid(rect.y0 + v - grid.top_px, grid.cells_per_px_y, grid.height), window.y0, window.height);
    const float* upper = window.scores.data() + y.first * static_cast<std::size_t>(window.width);
    const float* lower = window.scores.data() + y.second * static_cast<std::size_t>(window.width);
    std::uint8_t* out = mask.row(v);
    for (const Between& x : columns) {
      const float above = mix(upper[x.first], upper[x.second], x.share);
      const float below = mix(lower[x.first], lower[x.second], x.share);
      *out++ = mix(above, below, y.share) > threshold ? 1 : 0;
    }
  }
  return mask;
}

std::vector<ClassProbability> distribution_of(const std::vector<float>& shares, const std::vector<ClassId>& class_of) {
  constexpr float kLeastProbability = 1e-3F;  // less is not worth its place in the map
  std::map<ClassId, float> share_of;
  for (std::size_t c = 0; c < class_of.size(); ++c) {
    if (class_of[c] != ClassId::kUnknown) share_of[class_of[c]] += shares[c];
  }
  float total = 0;
  for (const auto& [id, share] : share_of) total += share;
  std::erase_if(share_of, [&](const auto& entry) { return !(entry.second >= kLeastProbability * total); });
  float kept = 0;
  for (const auto& [id, share] : share_of) kept += share;
  std::vector<ClassProbability> probabilities;
  for (const auto& [id, share] : share_of) probabilities.push_back({id, share / kept});
  return probabilities;
}

void drop_small(std::vector<Instance>& instances, const Thresholds& thresholds) {
  std::erase_if(instances, [&](const Instance& instance) {
    const auto pixels = instance.mask.pixels();
    return std::count(pixels.begin(), pixels.end(), 1) < thresholds.min_area_px;
  });
}

}  // namespace panoptic
