// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/depth_tiles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

#include "panoptic/base/clones.h"
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

// Where the bricks of a block lie in the view: depths in metres, and columns and rows of pixels, a little more than needed. A
// brick with nothing to look at has last_u < first_u.
struct BricksInView {
  alignas(64) float nearest_m[kBlockBricks];
  alignas(64) float farthest_m[kBlockBricks];
  alignas(64) std::int32_t first_u[kBlockBricks];
  alignas(64) std::int32_t last_u[kBlockBricks];
  alignas(64) std::int32_t first_v[kBlockBricks];
  alignas(64) std::int32_t last_v[kBlockBricks];
};

void find_bricks(const KernelFrame& frame_in, const BlockInCamera& place_in, BricksInView& bricks);

// One axis of the image, in pixels.
struct ImageAxis {
  float focal, center, size;
};

struct PixelSpan {
  std::int32_t first, last;
};

// The pixels between two lines of sight, given by their places at the brick's nearest and farthest depth; one more at each
// side, for rounding.
[[gnu::always_inline]] static inline PixelSpan span_px(const ImageAxis& axis, float low, float high, float per_near,
                                                       float per_far) {
  const float from = low * (low < 0 ? per_near : per_far) * axis.focal + axis.center - 1;
  const float to = high * (high < 0 ? per_far : per_near) * axis.focal + axis.center + 2;
  const float begin = from > 0 ? (from < axis.size ? from : axis.size) : 0.0F;
  const float end = to < axis.size - 1 ? (to > -1 ? to : -1.0F) : axis.size - 1;
  return {static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end)};
}

PANOPTIC_CLONES
void find_bricks(const KernelFrame& frame_in, const BlockInCamera& place_in, BricksInView& bricks) {
  const KernelFrame frame = frame_in;
  const BlockInCamera place = place_in;
  BricksInView* __restrict out = &bricks;
  constexpr float kHalf = 0.5F * (kBrickSide - 1);  // from the middle of a brick to its outer voxels
  constexpr float kNearest_m = 1e-3F;               // of bricks whose place in the view is worked out
  float half[3];
  for (int a = 0; a < 3; ++a) {
    half[a] = kHalf * (std::abs(place.step_x[a]) + std::abs(place.step_y[a]) + std::abs(place.step_z[a]));
  }
  const ImageAxis along_u{frame.fx, frame.cx, static_cast<float>(frame.width)};
  const ImageAxis along_v{frame.fy, frame.cy, static_cast<float>(frame.height)};
  for (int n = 0; n < kBlockBricks; ++n) {
    const float ix = static_cast<float>(kBrickSide * (n & 3)) + kHalf;
    const float iy = static_cast<float>(kBrickSide * (n >> 2 & 3)) + kHalf;
    const float iz = static_cast<float>(kBrickSide * (n >> 4)) + kHalf;
    const float x = place.origin[0] + ix * place.step_x[0] + iy * place.step_y[0] + iz * place.step_z[0];
    const float y = place.origin[1] + ix * place.step_x[1] + iy * place.step_y[1] + iz * place.step_z[1];
    const float z = place.origin[2] + ix * place.step_x[2] + iy * place.step_y[2] + iz * place.step_z[2];
    const float near = z - half[2];
    const float far = z + half[2];
    const bool clear = near > kNearest_m;
    const float per_near = 1.0F / (clear ? near : 1.0F);
    const float per_far = 1.0F / (clear ? far : 1.0F);
    const PixelSpan u = span_px(along_u, x - half[0], x + half[0], per_near, per_far);
    const PixelSpan v = span_px(along_v, y - half[1], y + half[1], per_near, per_far);
    out->nearest_m[n] = near;
    out->farthest_m[n] = far;
    out->first_u[n] = clear ? u.first : 0;
    out->last_u[n] = clear ? u.last : (far > 0 ? frame.width - 1 : -1);
    out->first_v[n] = clear ? v.first : 0;
    out->last_v[n] = clear ? v.last : frame.height - 1;
  }
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
  TileColumns columns{std::vector<float>(width, kInfinity), std::vector<float>(width, -kInfinity), std::vector<float>(width, 1.0F)};
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
  kernels::BricksInView view;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by find_bricks
  kernels::find_bricks(frame, place, view);
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
