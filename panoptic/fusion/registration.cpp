// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/registration.h"

#include <algorithm>
#include <limits>

#include "panoptic/base/parallel.h"

namespace panoptic {
namespace {

// A cell of the visibility test is 2x2 colour pixels, so that it has no holes where colour pixels outnumber depth pixels.
constexpr int kCell_px = 2;
// A surface this much behind the nearest one in its cell is hidden: more than depth noise and slant within a cell.
constexpr float kHiddenBehind_m = 0.03F;
constexpr float kHiddenBehindShare = 0.02F;
constexpr int kBands = 8;

int cells(int pixels) { return (pixels + kCell_px - 1) / kCell_px; }

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

Fields fields(DepthOptions& o) {
  return {{"min_m", &o.min_m, "nearer depth readings are ignored", in_range(0, 100)},
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
  for (std::size_t i = 0; i < frame.depth.size(); ++i) {
    const float z = frame.depth[i];
    result_.depth[i] = (z >= options_.min_m) & (z <= options_.max_m) ? z : 0.0F;  // NaN fails both
  }
}

void Registration::gather_registered(const Frame& frame, const Segmentation& segmentation) {
  const bool labelled = !segmentation.segment_at.empty();
  for (std::size_t i = 0; i < result_.pixel_count(); ++i) {
    const bool reading = result_.depth[i] > 0;
    result_.color[i] = reading ? packed(frame.color[i]) : 0;
    result_.segment[i] = reading && labelled ? segmentation.segment_at[i] : RegisteredFrame::kNoSegment;
  }
}

// Every depth pixel into the colour image: rows side by side, straight-line code that vectorises.
void Registration::project(const Frame& frame) {
  color_pixel_.resize(result_.pixel_count());
  color_depth_.resize(result_.pixel_count());
  const Camera& d = frame.depth_camera;
  const Camera& c = frame.color_camera;
  const Eigen::Matrix3f r = frame.color_from_depth.linear().cast<float>();
  const Vec3f t = frame.color_from_depth.translation().cast<float>();
  const auto fx = static_cast<float>(c.fx);
  const auto fy = static_cast<float>(c.fy);
  const auto cx = static_cast<float>(c.cx);
  const auto cy = static_cast<float>(c.cy);
  const auto width = static_cast<float>(c.width);
  const auto height = static_cast<float>(c.height);
  parallel_for(static_cast<std::size_t>(result_.height), [&](std::size_t row) {
    const auto y = static_cast<float>((static_cast<double>(row) - d.cy) / d.fy);
    const auto x0 = static_cast<float>(-d.cx / d.fx);
    const auto x_step = static_cast<float>(1 / d.fx);
    const Vec3f base = r.col(1) * y + r.col(2);
    const std::size_t first = row * static_cast<std::size_t>(result_.width);
    const float* depth = result_.depth.data() + first;
    std::int32_t* pixel = color_pixel_.data() + first;
    float* color_depth = color_depth_.data() + first;
    const float rx = r(0, 0), ry = r(1, 0), rz = r(2, 0), bx = base.x(), by = base.y(), bz = base.z();
    const float tx = t.x(), ty = t.y(), tz = t.z();
    for (int u = 0; u < result_.width; ++u) {
      const float z = depth[u];
      const float x = x0 + static_cast<float>(u) * x_step;
      const float zc = z * (rz * x + bz) + tz;
      const float inverse = 1.0F / zc;
      const float uc = fx * (z * (rx * x + bx) + tx) * inverse + cx + 0.5F;
      const float vc = fy * (z * (ry * x + by) + ty) * inverse + cy + 0.5F;
      const bool inside = (z > 0) & (zc > 0) & (uc >= 0) & (uc < width) & (vc >= 0) & (vc < height);
      const auto ui = static_cast<std::int32_t>(inside ? uc : 0.0F);
      const auto vi = static_cast<std::int32_t>(inside ? vc : 0.0F);
      pixel[u] = inside ? vi * c.width + ui : -1;
      color_depth[u] = zc;
    }
  });
}

// The smallest colour-camera depth per cell. Bands of rows fill tables of their own, which are then merged: a minimum does not
// depend on the order.
void Registration::find_nearest(const Frame& frame) {
  const int cell_width = cells(frame.color.width());
  const std::size_t cell_count = static_cast<std::size_t>(cell_width) * static_cast<std::size_t>(cells(frame.color.height()));
  nearest_.resize(kBands);
  parallel_for(kBands, [&](std::size_t band) {
    nearest_[band].assign(cell_count, std::numeric_limits<float>::max());
    float* nearest = nearest_[band].data();
    const Rows rows = band_rows(band, result_.height);
    const std::size_t begin = static_cast<std::size_t>(rows.begin) * static_cast<std::size_t>(result_.width);
    const std::size_t end = static_cast<std::size_t>(rows.end) * static_cast<std::size_t>(result_.width);
    for (std::size_t i = begin; i < end; ++i) {
      if (color_pixel_[i] < 0) continue;
      const int u = color_pixel_[i] % frame.color.width();
      const int v = color_pixel_[i] / frame.color.width();
      float& cell = nearest[(v / kCell_px) * cell_width + u / kCell_px];
      cell = std::min(cell, color_depth_[i]);
    }
  });
  for (std::size_t band = 1; band < kBands; ++band) {
    for (std::size_t i = 0; i < cell_count; ++i) nearest_[0][i] = std::min(nearest_[0][i], nearest_[band][i]);
  }
}

void Registration::gather_visible(const Frame& frame, const Segmentation& segmentation) {
  const bool labelled = !segmentation.segment_at.empty();
  const int cell_width = cells(frame.color.width());
  parallel_for(static_cast<std::size_t>(result_.height), [&](std::size_t row) {
    const std::size_t begin = row * static_cast<std::size_t>(result_.width);
    for (std::size_t i = begin; i < begin + static_cast<std::size_t>(result_.width); ++i) {
      result_.color[i] = 0;
      result_.segment[i] = RegisteredFrame::kNoSegment;
      if (color_pixel_[i] < 0) continue;
      const int u = color_pixel_[i] % frame.color.width();
      const int v = color_pixel_[i] / frame.color.width();
      const float nearest = nearest_[0][static_cast<std::size_t>((v / kCell_px) * cell_width + u / kCell_px)];
      if (color_depth_[i] > nearest + std::max(kHiddenBehind_m, kHiddenBehindShare * nearest)) continue;
      const auto source = static_cast<std::size_t>(color_pixel_[i]);
      result_.color[i] = packed(frame.color[source]);
      if (labelled) result_.segment[i] = segmentation.segment_at[source];
    }
  });
}

}  // namespace panoptic
