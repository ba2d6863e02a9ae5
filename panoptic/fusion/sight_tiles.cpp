// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/sight_tiles.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "panoptic/base/clones.h"
#include "panoptic/parallel.h"

namespace panoptic {

namespace kernels {

void least_of_rows(const float* a, const float* b, std::size_t count, float* out);
void most_of_rows(const float* a, const float* b, std::size_t count, float* out);
void take_row(const float* depth, std::size_t count, float* certain, float* nearest, std::int32_t* missing);
void halve_row(std::size_t count, float* certain, float* nearest, std::int32_t* missing);

// Two columns become one, in place.
PANOPTIC_CLONES
void halve_row(std::size_t count, float* certain, float* nearest, std::int32_t* missing) {
  for (std::size_t k = 0; k < count; ++k) certain[k] = certain[2 * k] < certain[2 * k + 1] ? certain[2 * k] : certain[2 * k + 1];
  for (std::size_t k = 0; k < count; ++k) nearest[k] = nearest[2 * k] < nearest[2 * k + 1] ? nearest[2 * k] : nearest[2 * k + 1];
  for (std::size_t k = 0; k < count; ++k) missing[k] = missing[2 * k] + missing[2 * k + 1];
}

// A row of pixels into those of a tile above each other.
PANOPTIC_CLONES
void take_row(const float* depth, std::size_t count, float* certain, float* nearest, std::int32_t* missing) {
  const float* __restrict z = depth;
  float* __restrict sure = certain;
  float* __restrict near = nearest;
  std::int32_t* __restrict holes = missing;
  for (std::size_t k = 0; k < count; ++k) {
    const float reading = z[k] > 0 ? z[k] : std::numeric_limits<float>::infinity();
    sure[k] = z[k] < sure[k] ? z[k] : sure[k];
    near[k] = reading < near[k] ? reading : near[k];
    holes[k] += z[k] > 0 ? 0 : 1;
  }
}

PANOPTIC_CLONES
void least_of_rows(const float* a, const float* b, std::size_t count, float* out) {
  for (std::size_t k = 0; k < count; ++k) out[k] = a[k] < b[k] ? a[k] : b[k];
}

PANOPTIC_CLONES
void most_of_rows(const float* a, const float* b, std::size_t count, float* out) {
  for (std::size_t k = 0; k < count; ++k) out[k] = a[k] > b[k] ? a[k] : b[k];
}

}  // namespace kernels

namespace {

using Combine = void (*)(const float*, const float*, std::size_t, float*);

struct Size {
  std::size_t columns;
  std::size_t rows;
};

// Each tile with those `step` to the right, below and across, as far as they are there.
void double_tiles(const std::vector<float>& fine, const Size& size, std::size_t step, Combine combine, std::vector<float>& out) {
  out.resize(fine.size());
  for (std::size_t row = 0; row < size.rows; ++row) {
    const float* from = fine.data() + row * size.columns;
    float* to = out.data() + row * size.columns;
    combine(from, from + step, size.columns - step, to);
    std::copy(from + size.columns - step, from + size.columns, to + size.columns - step);
  }
  for (std::size_t row = 0; row + step < size.rows; ++row) {
    float* to = out.data() + row * size.columns;
    combine(to, to + step * size.columns, size.columns, to);
  }
}

}  // namespace

// The finest level and the missing pixels of one row of tiles.
void SightTiles::build_row(const float* depth_m, int width, int height, int row) {
  constexpr int kTile_px = 1 << kLog2_px;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto across = static_cast<std::size_t>(width);
  const auto columns = static_cast<std::size_t>(columns_);
  std::vector<float> certain(columns * kTile_px, kInfinity);
  std::vector<float> nearest(columns * kTile_px, kInfinity);
  std::vector<std::int32_t> missing(columns * kTile_px, 0);
  for (int v = row * kTile_px; v < std::min(height, (row + 1) * kTile_px); ++v) {
    kernels::take_row(depth_m + static_cast<std::size_t>(v) * across, across, certain.data(), nearest.data(), missing.data());
  }
  for (std::size_t count = columns * kTile_px / 2; count >= columns; count /= 2) {
    kernels::halve_row(count, certain.data(), nearest.data(), missing.data());
  }
  const std::size_t first = static_cast<std::size_t>(row) * columns;
  std::int32_t* holes = missing_.data() + (static_cast<std::size_t>(row) + 1) * (columns + 1) + 1;
  for (std::size_t column = 0; column < columns; ++column) {
    levels_[0].certain[first + column] = certain[column];
    levels_[0].nearest[first + column] = nearest[column];
    levels_[0].farthest[first + column] = nearest[column] < kInfinity ? nearest[column] : 0.0F;
    holes[column] = missing[column];
  }
}

void SightTiles::build(const float* depth_m, int width, int height) {
  constexpr int kTile_px = 1 << kLog2_px;
  width_ = width;
  height_ = height;
  columns_ = (width + kTile_px - 1) / kTile_px;
  rows_ = (height + kTile_px - 1) / kTile_px;
  const Size size{static_cast<std::size_t>(columns_), static_cast<std::size_t>(rows_)};
  const std::size_t tiles = size.columns * size.rows;
  if (levels_.empty()) levels_.resize(1);
  for (std::vector<float>* plane : {&levels_[0].certain, &levels_[0].nearest, &levels_[0].farthest}) plane->resize(tiles);
  missing_.assign((size.columns + 1) * (size.rows + 1), 0);
  parallel_for(size.rows, [&](std::size_t row) { build_row(depth_m, width, height, static_cast<int>(row)); });
  for (std::size_t row = 1; row <= size.rows; ++row) {
    std::int32_t* here = missing_.data() + row * (size.columns + 1);
    const std::int32_t* above = here - (size.columns + 1);
    std::int32_t in_row = 0;
    for (std::size_t column = 1; column <= size.columns; ++column) {
      in_row += here[column];
      here[column] = in_row + above[column];
    }
  }
  std::size_t level = 1;
  for (std::size_t step = 1; 2 * step <= std::min(size.columns, size.rows); step *= 2, ++level) {
    if (levels_.size() == level) levels_.emplace_back();
    const Level& fine = levels_[level - 1];
    double_tiles(fine.certain, size, step, kernels::least_of_rows, levels_[level].certain);
    double_tiles(fine.nearest, size, step, kernels::least_of_rows, levels_[level].nearest);
    double_tiles(fine.farthest, size, step, kernels::most_of_rows, levels_[level].farthest);
  }
}

float SightTiles::missing(const PixelArea& pixels) const {
  const int first_column = pixels.first_u >> kLog2_px;
  const int first_row = pixels.first_v >> kLog2_px;
  const int end_column = (pixels.last_u >> kLog2_px) + 1;
  const int end_row = (pixels.last_v >> kLog2_px) + 1;
  const auto before = [&](int column, int row) { return missing_[static_cast<std::size_t>(row * (columns_ + 1) + column)]; };
  const int holes = before(end_column, end_row) - before(first_column, end_row) - before(end_column, first_row) +
                    before(first_column, first_row);
  const int across = std::min(end_column << kLog2_px, width_) - (first_column << kLog2_px);
  const int down = std::min(end_row << kLog2_px, height_) - (first_row << kLog2_px);
  return static_cast<float>(holes) / static_cast<float>(across * down);
}

template <std::vector<float> SightTiles::Level::*Plane, bool Least>
float SightTiles::over(const PixelArea& pixels) const {
  const int first_column = pixels.first_u >> kLog2_px;
  const int first_row = pixels.first_v >> kLog2_px;
  const int columns = (pixels.last_u >> kLog2_px) - first_column + 1;
  const int rows = (pixels.last_v >> kLog2_px) - first_row + 1;
  const auto level = static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(std::min(columns, rows))) - 1);
  const std::vector<float>& tiles = levels_[level].*Plane;
  const int step = 1 << level;
  float best = Least ? std::numeric_limits<float>::infinity() : 0.0F;
  // The last window of each direction ends with the rectangle, and overlaps the one before.
  for (int down = 0;; down = std::min(down + step, rows - step)) {
    const float* row = tiles.data() + (first_row + down) * columns_ + first_column;
    for (int along = 0;; along = std::min(along + step, columns - step)) {
      best = Least ? std::min(best, row[along]) : std::max(best, row[along]);
      if (along == columns - step) break;
    }
    if (down == rows - step) break;
  }
  return best;
}

template float SightTiles::over<&SightTiles::Level::certain, true>(const PixelArea& pixels) const;
template float SightTiles::over<&SightTiles::Level::nearest, true>(const PixelArea& pixels) const;
template float SightTiles::over<&SightTiles::Level::farthest, false>(const PixelArea& pixels) const;

}  // namespace panoptic
