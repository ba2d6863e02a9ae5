// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/depth_tiles.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>

#include "panoptic/base/clones.h"
#include "panoptic/fusion/boxes_in_view.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr DepthRange kNoReading{kInfinity, -kInfinity, false};
constexpr int kTile_px = 1 << DepthTiles::kFinestLog2_px;

DepthRange both(const DepthRange& a, const DepthRange& b) {
  return {std::min(a.nearest_m, b.nearest_m), std::max(a.farthest_m, b.farthest_m), a.grazing || b.grazing};
}

DepthTiles::Level level_of(int columns, int rows) {
  return {columns, rows, std::vector<DepthRange>(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), kNoReading)};
}

// The level above: every tile covers two by two of `fine`.
DepthTiles::Level coarser(const DepthTiles::Level& fine) {
  DepthTiles::Level level = level_of((fine.columns + 1) / 2, (fine.rows + 1) / 2);
  for (int row = 0; row < fine.rows; ++row) {
    for (int column = 0; column < fine.columns; ++column) {
      DepthRange& range = level.tiles[static_cast<std::size_t>(row / 2 * level.columns + column / 2)];
      range = both(range, fine.tiles[static_cast<std::size_t>(row * fine.columns + column)]);
    }
  }
  return level;
}

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

void widen_by_row(const float* depth, int width, float* nearest, float* farthest);
void lower_by_row(const float* scale, int width, float* least);

PANOPTIC_CLONES
void widen_by_row(const float* depth, int width, float* nearest, float* farthest) {
  const float* __restrict z = depth;
  float* __restrict low = nearest;
  float* __restrict high = farthest;
  for (int u = 0; u < width; ++u) {
    const float near = z[u] > 0 ? z[u] : kInfinity;
    const float far = z[u] > 0 ? z[u] : -kInfinity;
    low[u] = near < low[u] ? near : low[u];
    high[u] = far > high[u] ? far : high[u];
  }
}

PANOPTIC_CLONES
void lower_by_row(const float* scale, int width, float* least) {
  const float* __restrict s = scale;
  float* __restrict low = least;
  for (int u = 0; u < width; ++u) low[u] = s[u] < low[u] ? s[u] : low[u];
}

}  // namespace kernels

namespace {

// Columns of the pixels that a row of tiles covers.
struct TileColumns {
  std::vector<float> nearest;
  std::vector<float> farthest;
  std::vector<float> least_scale;
};

TileColumns columns_of(const KernelFrame& frame, int first_row, int end_row) {
  const auto width = static_cast<std::size_t>(frame.width);
  TileColumns columns{std::vector<float>(width, kInfinity), std::vector<float>(width, -kInfinity),
                      std::vector<float>(width, 1.0F)};
  for (int v = first_row; v < end_row; ++v) {
    const std::size_t row = static_cast<std::size_t>(v) * width;
    kernels::widen_by_row(frame.depth + row, frame.width, columns.nearest.data(), columns.farthest.data());
    if (frame.scale != nullptr) kernels::lower_by_row(frame.scale + row, frame.width, columns.least_scale.data());
  }
  return columns;
}

}  // namespace

void DepthTiles::build(const KernelFrame& frame, const Band& band) {
  levels_.resize(1);
  Level& finest = levels_[0];
  finest = level_of((frame.width + kTile_px - 1) / kTile_px, (frame.height + kTile_px - 1) / kTile_px);
  parallel_for(static_cast<std::size_t>(finest.rows), [&](std::size_t row) {
    const int first = static_cast<int>(row) * kTile_px;
    const TileColumns columns = columns_of(frame, first, std::min(frame.height, first + kTile_px));
    DepthRange* tiles = finest.tiles.data() + row * static_cast<std::size_t>(finest.columns);
    for (std::size_t u = 0; u < columns.nearest.size(); ++u) {
      const float scale = columns.least_scale[u];
      const float longer_m = band.truncation_m * (1.0F / scale - 1.0F) * 1.01F;
      DepthRange& tile = tiles[u / kTile_px];
      tile = both(tile, {columns.nearest[u] - longer_m, columns.farthest[u] + longer_m, scale < 1});
    }
  });
  while (levels_.back().columns > 1 || levels_.back().rows > 1) levels_.push_back(coarser(levels_.back()));
}

BricksInBand bricks_in_band(const KernelFrame& frame, const DepthTiles& tiles, const BlockInCamera& place, const Band& band) {
  constexpr float kHalf = 0.5F * (kBrickSide - 1);  // from the middle of a brick to its outer voxels
  BoxesInView view;                                 // NOLINT(cppcoreguidelines-pro-type-member-init): filled by find_boxes
  kernels::find_boxes(frame, place, kHalf, view);
  const float reach = band.truncation_m * 1.01F;
  const auto most = static_cast<unsigned>(tiles.levels().size()) - 1;
  BricksInBand result;
  for (int n = 0; n < kBlockBricks; ++n) {
    const std::int32_t span = std::max(view.last_u[n] - view.first_u[n], view.last_v[n] - view.first_v[n]);
    if (view.last_u[n] < view.first_u[n] || view.last_v[n] < view.first_v[n]) continue;
    // Tiles at least as long as the span: two by two of them cover it.
    const auto wanted = static_cast<unsigned>(std::bit_width(static_cast<unsigned>(span) >> DepthTiles::kFinestLog2_px));
    const unsigned at = std::min(wanted, most);
    const DepthTiles::Level& level = tiles.levels()[at];
    const unsigned log2_px = DepthTiles::kFinestLog2_px + at;
    DepthRange range = kNoReading;
    for (int row = view.first_v[n] >> log2_px; row <= view.last_v[n] >> log2_px; ++row) {
      for (int column = view.first_u[n] >> log2_px; column <= view.last_u[n] >> log2_px; ++column) {
        range = both(range, level.tiles[static_cast<std::size_t>(row * level.columns + column)]);
      }
    }
    const bool near = range.nearest_m - reach < view.farthest_m[n] && range.farthest_m + reach > view.nearest_m[n];
    result.bricks |= std::uint64_t{near} << n;
    result.grazing |= near && range.grazing;
  }
  return result;
}

}  // namespace panoptic
