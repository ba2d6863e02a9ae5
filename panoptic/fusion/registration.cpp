// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "panoptic/base/clones.h"
#include "panoptic/base/parallel.h"

namespace panoptic {
namespace {

// A cell of the visibility test is as wide as two depth pixels, so that it has no holes where colour pixels outnumber depth
// pixels and spans little of a slanted surface where they do not.
int cell_size_px(const Camera& color, const Camera& depth) {
  constexpr double kDepthPixels = 2;
  return std::max(1, static_cast<int>(std::lround(kDepthPixels * color.fx / depth.fx)));
}
// A surface this much behind the nearest one in its cell is hidden: more than depth noise and slant within a cell.
constexpr float kHiddenBehind_m = 0.03F;
constexpr float kHiddenBehindShare = 0.02F;
constexpr int kBands = 4;

int cells(int pixels, int cell_px) { return (pixels + cell_px - 1) / cell_px; }

std::uint32_t packed(Rgb c) { return 0xFF000000U | std::uint32_t{c.r} << 16 | std::uint32_t{c.g} << 8 | c.b; }

struct Rows {
  int begin;
  int end;
};
Rows band_rows(std::size_t band, int height) {
  const int b = static_cast<int>(band);
  return {height * b / kBands, height * (b + 1) / kBands};
}

}  // namespace

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

void project_row(const RowProjection& p, const float* depth, const ProjectedRow& out);

PANOPTIC_CLONES
void project_row(const RowProjection& p, const float* depth, const ProjectedRow& out) {
  const auto width = static_cast<float>(p.color_width);
  const auto height = static_cast<float>(p.color_height);
  const int cell_width = cells(p.color_width, p.cell_px);
  const float per_cell = 1.0F / static_cast<float>(p.cell_px);
  std::int32_t* __restrict color_pixel = out.color_pixel;
  std::int32_t* __restrict cell = out.cell;
  float* __restrict color_depth = out.color_depth;
  for (int u = 0; u < p.depth_width; ++u) {
    const float z = depth[u];
    const float x = p.x_first + static_cast<float>(u) * p.x_step;
    const float zc = z * (p.per_x[2] * x + p.base[2]) + p.offset[2];
    const float inverse = 1.0F / zc;
    const float uc = p.fx * (z * (p.per_x[0] * x + p.base[0]) + p.offset[0]) * inverse + p.cx + 0.5F;
    const float vc = p.fy * (z * (p.per_x[1] * x + p.base[1]) + p.offset[1]) * inverse + p.cy + 0.5F;
    const bool inside = (z > 0) & (zc > 0) & (uc >= 0) & (uc < width) & (vc >= 0) & (vc < height);
    const auto ui = static_cast<std::int32_t>(inside ? uc : 0.0F);
    const auto vi = static_cast<std::int32_t>(inside ? vc : 0.0F);
    color_pixel[u] = inside ? vi * p.color_width + ui : -1;
    cell[u] = static_cast<std::int32_t>(static_cast<float>(vi) * per_cell) * cell_width +
              static_cast<std::int32_t>(static_cast<float>(ui) * per_cell);
    color_depth[u] = zc;
  }
}

}  // namespace kernels

Fields fields(DepthOptions& o) {
  return {{"min_m", &o.min_m, "nearer depth readings are ignored", in_range(0.01, 100)},
          {"max_m", &o.max_m, "farther depth readings are ignored", in_range(0.1, 1000)}};
}

const RegisteredFrame& Registration::apply(const Frame& frame, const Segmentation& segmentation) {
  resize(frame);
  clean_depth(frame);
  const bool one_camera = frame.color_camera == frame.depth_camera && frame.color_from_depth.matrix().isIdentity(0);
  if (one_camera) {
    gather_registered(frame, segmentation);
  } else {
    project(frame);
    find_nearest(frame);
    gather_visible(frame, segmentation);
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
  result_.color.back() = 0;
  result_.segment.back() = RegisteredFrame::kNoSegment;
}

void Registration::clean_depth(const Frame& frame) {
  std::array<std::size_t, kBands> readings{};
  std::array<float, kBands> farthest_m{};
  parallel_for(kBands, [&](std::size_t band) {
    const Rows rows = band_rows(band, result_.height);
    std::size_t count = 0;
    float farthest = 0;
    for (std::size_t i = result_.index(rows.begin); i < result_.index(rows.end); ++i) {
      const float z = frame.depth[i];
      const bool usable = (z >= options_.min_m) & (z <= options_.max_m);  // NaN fails both
      const float kept = usable ? z : 0.0F;
      result_.depth[i] = kept;
      count += usable ? 1 : 0;
      farthest = kept > farthest ? kept : farthest;
    }
    readings[band] = count;
    farthest_m[band] = farthest;
  });
  result_.readings = std::accumulate(readings.begin(), readings.end(), std::size_t{0});
  result_.farthest_m = *std::max_element(farthest_m.begin(), farthest_m.end());
}

void Registration::gather_registered(const Frame& frame, const Segmentation& segmentation) {
  const bool labelled = !segmentation.segment_at.empty();
  for (std::size_t i = 0; i < result_.pixel_count(); ++i) {
    const bool reading = result_.depth[i] > 0;
    result_.color[i] = reading ? packed(frame.color[i]) : 0;
    result_.segment[i] = reading && labelled ? segmentation.segment_at[i] : RegisteredFrame::kNoSegment;
  }
}

// Every depth pixel into the colour image.
void Registration::project(const Frame& frame) {
  color_pixel_.resize(result_.pixel_count());
  cell_.resize(result_.pixel_count());
  color_depth_.resize(result_.pixel_count());
  const Camera& d = frame.depth_camera;
  const Camera& c = frame.color_camera;
  cell_px_ = cell_size_px(c, d);
  const Eigen::Matrix3f r = frame.color_from_depth.linear().cast<float>();
  const Vec3f t = frame.color_from_depth.translation().cast<float>();
  parallel_for(static_cast<std::size_t>(result_.height), [&](std::size_t row) {
    const auto y = static_cast<float>((static_cast<double>(row) - d.cy) / d.fy);
    const Vec3f base = r.col(1) * y + r.col(2);
    kernels::RowProjection p{};
    for (int a = 0; a < 3; ++a) {
      p.per_x[a] = r(a, 0);
      p.base[a] = base[a];
      p.offset[a] = t[a];
    }
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
    const std::size_t first = row * static_cast<std::size_t>(result_.width);
    kernels::project_row(p, result_.depth.data() + first,
                         {color_pixel_.data() + first, cell_.data() + first, color_depth_.data() + first});
  });
}

// The smallest colour-camera depth per cell. Bands of rows fill tables of their own, which are then merged: a minimum does not
// depend on the order.
void Registration::find_nearest(const Frame& frame) {
  const std::size_t cell_count = static_cast<std::size_t>(cells(frame.color.width(), cell_px_)) *
                                 static_cast<std::size_t>(cells(frame.color.height(), cell_px_));
  nearest_.resize(kBands);
  parallel_for(kBands, [&](std::size_t band) {
    nearest_[band].assign(cell_count, std::numeric_limits<float>::max());
    float* nearest = nearest_[band].data();
    const Rows rows = band_rows(band, result_.height);
    for (std::size_t i = result_.index(rows.begin); i < result_.index(rows.end); ++i) {
      if (color_pixel_[i] < 0) continue;
      float& cell = nearest[cell_[i]];
      cell = std::min(cell, color_depth_[i]);
    }
  });
  for (std::size_t band = 1; band < kBands; ++band) {
    for (std::size_t i = 0; i < cell_count; ++i) nearest_[0][i] = std::min(nearest_[0][i], nearest_[band][i]);
  }
}

void Registration::gather_visible(const Frame& frame, const Segmentation& segmentation) {
  const bool labelled = !segmentation.segment_at.empty();
  parallel_for(static_cast<std::size_t>(result_.height), [&](std::size_t row) {
    const std::size_t begin = row * static_cast<std::size_t>(result_.width);
    for (std::size_t i = begin; i < begin + static_cast<std::size_t>(result_.width); ++i) {
      result_.color[i] = 0;
      result_.segment[i] = RegisteredFrame::kNoSegment;
      if (color_pixel_[i] < 0) continue;
      const float nearest = nearest_[0][static_cast<std::size_t>(cell_[i])];
      if (color_depth_[i] > nearest + std::max(kHiddenBehind_m, kHiddenBehindShare * nearest)) continue;
      const auto source = static_cast<std::size_t>(color_pixel_[i]);
      result_.color[i] = packed(frame.color[source]);
      if (labelled) result_.segment[i] = segmentation.segment_at[source];
    }
  });
}

}  // namespace panoptic
