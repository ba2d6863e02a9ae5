// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/distance_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/planning/mixed_color.h"

namespace panoptic {
namespace {

constexpr Rgb kBehind = {72, 72, 78};
constexpr Rgb kLine = {40, 44, 58};
constexpr std::uint8_t kOpaque = 215;  // the floor shows through

// Distances as shares of the cap, and their colours.
struct Stop {
  double share = 0;
  Rgb color;
};
constexpr std::array<Stop, 5> kStops = {
    {{0, {200, 48, 44}}, {0.1, {240, 145, 66}}, {0.25, {246, 226, 140}}, {0.55, {142, 202, 190}}, {1, {58, 112, 180}}}};

Rgb color_of_share(double share) {
  for (std::size_t i = 1; i < kStops.size(); ++i) {
    const Stop& low = kStops[i - 1];
    const Stop& high = kStops[i];
    if (share <= high.share) return mixed(low.color, high.color, (share - low.share) / (high.share - low.share));
  }
  return kStops.back().color;
}

// One level of the values.
class Slice {
 public:
  Slice(const DistanceField::Values& values, int level)
      : size_(values.size.head<2>()),
        distance_m_(values.distance_m.data() + static_cast<std::size_t>(level) * static_cast<std::size_t>(size_.prod())) {}

  // The distance between the centres of cells, in cells from the first one's; beside unknown cells that of the cell itself.
  float at(double x, double y) const {
    const int x0 = static_cast<int>(std::floor(x));
    const int y0 = static_cast<int>(std::floor(y));
    const auto fx = static_cast<float>(x - x0);
    const auto fy = static_cast<float>(y - y0);
    const float row = (1 - fx) * cell(x0, y0) + fx * cell(x0 + 1, y0);
    const float next_row = (1 - fx) * cell(x0, y0 + 1) + fx * cell(x0 + 1, y0 + 1);
    const float between = (1 - fy) * row + fy * next_row;
    return std::isnan(between) ? cell(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))) : between;
  }

 private:
  float cell(int x, int y) const {
    x = std::clamp(x, 0, size_.x() - 1);
    y = std::clamp(y, 0, size_.y() - 1);
    return distance_m_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.x()) + static_cast<std::size_t>(x)];
  }

  Eigen::Vector2i size_;
  const float* distance_m_;
};

// Whether a line of equal distance runs between this pixel and its neighbours to the right and below.
bool is_on_line(const Slice& slice, double x, double y, double step, float here_m) {
  const auto band = [](float distance_m) { return std::floor(distance_m / kSliceLine_m); };
  const float right_m = slice.at(x + step, y);
  const float below_m = slice.at(x, y - step);
  return here_m > 0 && ((right_m > 0 && band(right_m) != band(here_m)) || (below_m > 0 && band(below_m) != band(here_m)));
}

}  // namespace

std::vector<std::uint8_t> distance_slice_png(const DistanceField::Values& values, double cap_m, int level) {
  PANOPTIC_ASSERT(level >= 0 && level < values.size.z());
  const int width = values.size.x() * kSlicePixelsPerCell;
  const int height = values.size.y() * kSlicePixelsPerCell;
  const Slice slice(values, level);
  constexpr double kStep = 1.0 / kSlicePixelsPerCell;
  Image<Rgb> color(width, height, kBehind);
  Image<std::uint8_t> alpha(width, height, 0);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double x = (u + 0.5) * kStep - 0.5;
      const double y = (height - v - 0.5) * kStep - 0.5;
      const float here_m = slice.at(x, y);
      if (std::isnan(here_m)) continue;
      alpha(u, v) = kOpaque;
      if (here_m >= 0) color(u, v) = color_of_share(std::min(1.0, here_m / cap_m));
      if (is_on_line(slice, x, y, kStep, here_m)) color(u, v) = mixed(color(u, v), kLine, 0.5);
    }
  }
  return encode_png(color, alpha);
}

}  // namespace panoptic
