// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/registration.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

#include "panoptic/base/clones.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

// A cell of the visibility test is as wide as two depth pixels, so that it has no holes where colour pixels outnumber depth
// pixels and spans little of a slanted surface where they do not.
int cell_size_px(const Camera& color, const Camera& depth) {
  constexpr double kDepthPixels = 2;
  const double most = std::max(color.width, color.height);  // then there is one cell
  return static_cast<int>(std::lround(std::clamp(kDepthPixels * color.fx / depth.fx, 1.0, most)));
}
// A surface this much behind the nearest one in its cell is hidden: more than depth noise and slant within a cell.
constexpr float kHiddenBehind_m = 0.03F;
constexpr float kHiddenBehindShare = 0.02F;
constexpr std::size_t kBands = 16;  // of rows, worked side by side: fixed, so that nothing depends on the thread count
constexpr float kFar = std::numeric_limits<float>::max();

int cells(int pixels, int cell_px) { return (pixels + cell_px - 1) / cell_px; }

std::uint32_t packed(Rgb c) { return 0xFF000000U | std::uint32_t{c.r} << 16 | std::uint32_t{c.g} << 8 | c.b; }

}  // namespace

// Constants are copied and pointers restricted in all kernels: otherwise GCC takes every store for a change of the inputs and
// does not vectorise.
namespace kernels {

// How one row of depth pixels maps into the colour image: pixel u at depth z is the point z * (per_x * x(u) + base) + offset of
// the colour camera, x(u) = x_first + u * x_step.
struct RowProjection {
  float per_x[3], base[3], offset[3];
  float x_first, x_step;
  float fx, fy, cx, cy;
  int depth_width, color_width, color_height, cell_px;
};
struct ProjectedRow {
  std::int32_t* color_pixel;
  std::int32_t* cell;
  float* color_depth;
};
struct CellRange {
  std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
  std::int32_t highest = -1;
};
struct DepthRow {
  std::uint32_t readings = 0;
  float farthest_m = 0;
};

DepthRow clean_row(const DepthOptions& options, const float* raw, float* clean, int count);
CellRange project_row(const RowProjection& projection, const float* depth, const ProjectedRow& out);
void limit_cells(float* nearest, std::size_t count);

PANOPTIC_CLONES
DepthRow clean_row(const DepthOptions& options, const float* raw, float* clean, int count) {
  const float min_m = options.min_m;
  const float max_m = options.max_m;
  const float* __restrict from = raw;
  float* __restrict to = clean;
  std::int32_t readings = 0;
  std::int32_t farthest = 0;  // bits of a float that is not negative: they compare like the float, and integers vectorise
  for (int u = 0; u < count; ++u) {
    const float z = from[u];
    const bool usable = (z >= min_m) & (z <= max_m);  // NaN fails both
    to[u] = usable ? z : 0.0F;
    readings += usable ? 1 : 0;
  }
  for (int u = 0; u < count; ++u) {
    const auto bits = std::bit_cast<std::int32_t>(to[u]);
    farthest = bits > farthest ? bits : farthest;
  }
  return {static_cast<std::uint32_t>(readings), std::bit_cast<float>(farthest)};
}

// Pixels that fall outside the colour image get pixel 0 and the cell after the last, which nothing is visible in. Two loops over
// short pieces: in one, GCC turns `inside` into branches.
PANOPTIC_CLONES
CellRange project_row(const RowProjection& projection, const float* depth, const ProjectedRow& out) {
  constexpr int kPiece = 128;
  alignas(64) float us[kPiece];
  alignas(64) float vs[kPiece];
  alignas(64) std::int32_t masks[kPiece];  // all bits where inside
  const RowProjection p = projection;
  const auto width = static_cast<float>(p.color_width);
  const auto height = static_cast<float>(p.color_height);
  const int cell_width = cells(p.color_width, p.cell_px);
  const int outside = cell_width * cells(p.color_height, p.cell_px);
  const float per_cell = 1.0F / static_cast<float>(p.cell_px);
  std::int32_t lowest = outside;
  std::int32_t highest = -1;
  for (int begin = 0; begin < p.depth_width; begin += kPiece) {
    const int count = p.depth_width - begin < kPiece ? p.depth_width - begin : kPiece;
    const float* __restrict from = depth + begin;
    std::int32_t* __restrict color_pixel = out.color_pixel + begin;
    std::int32_t* __restrict cell = out.cell + begin;
    float* __restrict color_depth = out.color_depth + begin;
    for (int k = 0; k < count; ++k) {
      const float z = from[k];
      const float x = p.x_first + static_cast<float>(begin + k) * p.x_step;
      const float zc = z * (p.per_x[2] * x + p.base[2]) + p.offset[2];
      const float inverse = 1.0F / zc;
      const float uc = p.fx * (z * (p.per_x[0] * x + p.base[0]) + p.offset[0]) * inverse + p.cx + 0.5F;
      const float vc = p.fy * (z * (p.per_x[1] * x + p.base[1]) + p.offset[1]) * inverse + p.cy + 0.5F;
      const bool inside = (z > 0) & (zc > 0) & (uc >= 0) & (uc < width) & (vc >= 0) & (vc < height);
      us[k] = inside ? uc : 0.0F;
      vs[k] = inside ? vc : 0.0F;
      masks[k] = inside ? -1 : 0;
      color_depth[k] = zc;
    }
    for (int k = 0; k < count; ++k) {
      const auto ui = static_cast<std::int32_t>(us[k]);
      const auto vi = static_cast<std::int32_t>(vs[k]);
      const std::int32_t place = static_cast<std::int32_t>(static_cast<float>(vi) * per_cell) * cell_width +
                                 static_cast<std::int32_t>(static_cast<float>(ui) * per_cell);
      const std::int32_t low = (place & masks[k]) | (outside & ~masks[k]);
      const std::int32_t high = place | ~masks[k];
      color_pixel[k] = vi * p.color_width + ui;
      cell[k] = low;
      lowest = low < lowest ? low : lowest;
      highest = high > highest ? high : highest;
    }
  }
  return {lowest, highest};
}

// Turns the nearest depth in each cell into the depth beyond which its pixels are hidden.
PANOPTIC_CLONES
void limit_cells(float* nearest, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const float share = kHiddenBehindShare * nearest[i];
    nearest[i] += share > kHiddenBehind_m ? share : kHiddenBehind_m;
  }
}

}  // namespace kernels

Fields fields(DepthOptions& o) {
  return {{"min_m", &o.min_m, "nearer depth readings are ignored", in_range(0.01, 100)},
          {"max_m", &o.max_m, "farther depth readings are ignored", in_range(0.1, 1000)}};
}

RegisteredFrame& Registration::apply(const Frame& frame, const Segmentation& segmentation) {
  resize(frame);
  const bool one_camera = frame.color_camera == frame.depth_camera && frame.color_from_depth.matrix().isIdentity(0);
  parallel_for(kBands, [&](std::size_t band) {
    clean_depth(frame, bands_[band]);
    if (one_camera) {
      gather_registered(frame, segmentation, bands_[band]);
    } else {
      project(frame, bands_[band]);
    }
  });
  if (!one_camera) {
    limit_visibility();
    parallel_for(kBands, [&](std::size_t band) {
      if (frame.color.is_dense()) {
        gather_visible(frame.color.row(0), segmentation, bands_[band]);
      } else {
        gather_visible(frame.color, segmentation, bands_[band]);
      }
    });
  }
  result_.readings = 0;
  result_.farthest_m = 0;
  for (const Band& band : bands_) {
    result_.readings += band.readings;
    result_.farthest_m = std::max(result_.farthest_m, band.farthest_m);
  }
  return result_;
}

void Registration::resize(const Frame& frame) {
  result_.width = frame.depth.width();
  result_.height = frame.depth.height();
  const std::size_t padded = result_.pixel_count() + 1;
  result_.depth.resize(padded);
  result_.color.resize(padded);
  result_.segment.resize(padded);
  result_.depth.back() = 0;
  result_.depth_weight.assign(frame.depth_weight.empty() ? 0 : padded, 1.0F);
  result_.color.back() = 0;
  result_.segment.back() = RegisteredFrame::kNoSegment;
  cell_px_ = cell_size_px(frame.color_camera, frame.depth_camera);
  const std::size_t cell_count = static_cast<std::size_t>(cells(frame.color.width(), cell_px_)) *
                                 static_cast<std::size_t>(cells(frame.color.height(), cell_px_));
  limits_.resize(cell_count + 1);
  bands_.resize(kBands);
  for (std::size_t band = 0; band < kBands; ++band) {
    bands_[band].rows = {static_cast<int>(static_cast<std::size_t>(result_.height) * band / kBands),
                         static_cast<int>(static_cast<std::size_t>(result_.height) * (band + 1) / kBands)};
  }
}

void Registration::clean_depth(const Frame& frame, Band& band) {
  band.readings = 0;
  band.farthest_m = 0;
  for (int row = band.rows.begin; row < band.rows.end; ++row) {
    const kernels::DepthRow clean =
        kernels::clean_row(options_, frame.depth.row(row), result_.depth.data() + result_.index(row), result_.width);
    band.readings += clean.readings;
    band.farthest_m = std::max(band.farthest_m, clean.farthest_m);
    if (frame.depth_weight.empty()) continue;
    // Those of pixels without a reading can be anything, and must be finite.
    const float* weights = frame.depth_weight.row(row);
    std::transform(weights, weights + result_.width, result_.depth_weight.data() + result_.index(row),
                   [](float weight) { return weight > 0 && weight <= 1 ? weight : 1.0F; });
  }
}

void Registration::gather_registered(const Frame& frame, const Segmentation& segmentation, const Band& band) {
  const bool labelled = !segmentation.segment_at.empty();
  for (int row = band.rows.begin; row < band.rows.end; ++row) {
    const std::size_t first = result_.index(row);
    const Rgb* colors = frame.color.row(row);
    for (std::size_t u = 0; u < static_cast<std::size_t>(result_.width); ++u) {
      const bool reading = result_.depth[first + u] > 0;
      result_.color[first + u] = reading ? packed(colors[u]) : 0;
      result_.segment[first + u] = reading && labelled ? segmentation.segment_at[first + u] : RegisteredFrame::kNoSegment;
    }
  }
}

// Every depth pixel of the band into the colour image, and the smallest colour-camera depth per cell. Bands have tables of
// their own, of which they use what they fall on.
void Registration::project(const Frame& frame, Band& band) {
  const Camera& d = frame.depth_camera;
  const Camera& c = frame.color_camera;
  const auto width = static_cast<std::size_t>(result_.width);
  const std::size_t pixels = width * static_cast<std::size_t>(band.rows.end - band.rows.begin);
  band.color_pixel.resize(pixels);
  band.cell.resize(pixels);
  band.color_depth.resize(pixels);
  const Eigen::Matrix3f r = frame.color_from_depth.linear().cast<float>();
  const Vec3f t = frame.color_from_depth.translation().cast<float>();
  kernels::RowProjection p{};
  p.x_first = static_cast<float>(-d.cx / d.fx);
  p.x_step = static_cast<float>(1 / d.fx);
  p.fx = static_cast<float>(c.fx);
  p.fy = static_cast<float>(c.fy);
  p.cx = static_cast<float>(c.cx);
  p.cy = static_cast<float>(c.cy);
  p.depth_width = result_.width;
  p.color_width = c.width;
  p.color_height = c.height;
  p.cell_px = cell_px_;
  kernels::CellRange range;
  for (int row = band.rows.begin; row < band.rows.end; ++row) {
    const auto y = static_cast<float>((static_cast<double>(row) - d.cy) / d.fy);
    const Vec3f base = r.col(1) * y + r.col(2);
    for (int a = 0; a < 3; ++a) {
      p.per_x[a] = r(a, 0);
      p.base[a] = base[a];
      p.offset[a] = t[a];
    }
    const std::size_t first = width * static_cast<std::size_t>(row - band.rows.begin);
    const kernels::CellRange of_row =
        kernels::project_row(p, result_.depth.data() + result_.index(row),
                             {band.color_pixel.data() + first, band.cell.data() + first, band.color_depth.data() + first});
    range.lowest = std::min(range.lowest, of_row.lowest);
    range.highest = std::max(range.highest, of_row.highest);
  }
  find_nearest(band, static_cast<std::size_t>(std::max(0, range.lowest)), static_cast<std::size_t>(range.highest + 1));
}

void Registration::find_nearest(Band& band, std::size_t begin_cell, std::size_t end_cell) {
  band.nearest.resize(limits_.size());
  band.begin_cell = std::min(begin_cell, end_cell);
  band.end_cell = end_cell;
  std::fill(band.nearest.begin() + static_cast<std::ptrdiff_t>(band.begin_cell),
            band.nearest.begin() + static_cast<std::ptrdiff_t>(band.end_cell), kFar);
  float* __restrict nearest = band.nearest.data();
  const std::int32_t* cell = band.cell.data();
  const float* depth = band.color_depth.data();
  for (std::size_t i = 0; i < band.cell.size(); ++i) {
    const float before = nearest[cell[i]];
    nearest[cell[i]] = depth[i] < before ? depth[i] : before;
  }
}

// The bands' tables merged (a minimum does not depend on the order).
void Registration::limit_visibility() {
  std::fill(limits_.begin(), limits_.end(), kFar);
  for (const Band& band : bands_) {
    const float* __restrict from = band.nearest.data();
    float* __restrict to = limits_.data();
    for (std::size_t i = band.begin_cell; i < band.end_cell; ++i) to[i] = from[i] < to[i] ? from[i] : to[i];
  }
  kernels::limit_cells(limits_.data(), limits_.size());
  limits_.back() = -kFar;
}

// `colors`: by number of the colour pixel.
template <typename Colors>
void Registration::gather_visible(const Colors& colors, const Segmentation& segmentation, const Band& band) {
  const bool labelled = !segmentation.segment_at.empty();
  const std::uint16_t* segments = segmentation.segment_at.data();
  const float* limits = limits_.data();
  std::uint32_t* __restrict color = result_.color.data() + result_.index(band.rows.begin);
  std::uint16_t* __restrict segment = result_.segment.data() + result_.index(band.rows.begin);
  for (std::size_t i = 0; i < band.cell.size(); ++i) {
    const bool visible = band.color_depth[i] <= limits[band.cell[i]];
    const auto source = static_cast<std::size_t>(band.color_pixel[i]);
    color[i] = visible ? packed(colors[source]) : 0;
    segment[i] = visible && labelled ? segments[source] : RegisteredFrame::kNoSegment;
  }
}

}  // namespace panoptic
