// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/grazing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "panoptic/base/clones.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr int kReach_px = 2;  // of the pixels that tell how the surface lies

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

// Five rows of inverse depths, 0 where there is no reading; the middle one is worked on. And the camera's numbers for it.
struct GrazingRow {
  const float* inverse[2 * kReach_px + 1];
  float* scale;
  int width;
  float fx, fy, cx;
  float y;       // of the row, at depth 1
  float across;  // the truncation over the least reach across the surface
};

void invert_row(const float* depth, int width, float* inverse);
void scale_row(const GrazingRow& row_in);

PANOPTIC_CLONES
void invert_row(const float* depth, int width, float* inverse) {
  const float* __restrict z = depth;
  float* __restrict out = inverse;
  for (int u = 0; u < width; ++u) out[u] = z[u] > 0 ? 1.0F / z[u] : 0.0F;
}

// A plane is linear in inverse depth: w = n . (x, y, 1) with the plane n . p = 1, and the cosine of the view is
// w / (|n| |(x, y, 1)|).
PANOPTIC_CLONES
void scale_row(const GrazingRow& row_in) {
  const GrazingRow row = row_in;
  const float* __restrict w = row.inverse[kReach_px];
  const float* __restrict far_above = row.inverse[0];
  const float* __restrict above = row.inverse[1];
  const float* __restrict below = row.inverse[3];
  const float* __restrict far_below = row.inverse[4];
  float* __restrict scale = row.scale;
  constexpr float kBent = 0.5F;  // of the slope; at a step it is 1
  constexpr float kShortest = 1.0F / kLongestBand;
  for (int u = kReach_px; u < row.width - kReach_px; ++u) {
    const bool read = (w[u] > 0) & (w[u - 1] > 0) & (w[u + 1] > 0) & (w[u - 2] > 0) & (w[u + 2] > 0) & (above[u] > 0) &
                      (below[u] > 0) & (far_above[u] > 0) & (far_below[u] > 0);
    const float du = w[u + 2] - w[u - 2];
    const float dv = far_below[u] - far_above[u];
    const float near_du = w[u + 1] - w[u - 1];
    const float near_dv = below[u] - above[u];
    const float slope = std::abs(du) > std::abs(dv) ? std::abs(du) : std::abs(dv);
    const float bent = kBent * slope;
    const float far_bend_u = std::abs(w[u - 2] + w[u + 2] - 2 * w[u]);
    const float far_bend_v = std::abs(far_above[u] + far_below[u] - 2 * w[u]);
    const float near_bend_u = std::abs(2 * near_du - du);
    const float near_bend_v = std::abs(2 * near_dv - dv);
    const bool plane = (far_bend_u <= bent) & (far_bend_v <= bent) & (near_bend_u <= bent) & (near_bend_v <= bent);
    const float x = (static_cast<float>(u) - row.cx) / row.fx;
    const float nx = du * row.fx * (0.5F / kReach_px);
    const float ny = dv * row.fy * (0.5F / kReach_px);
    const float nz = w[u] - nx * x - ny * row.y;
    const float lengths = (nx * nx + ny * ny + nz * nz) * (x * x + row.y * row.y + 1);
    const float wanted = row.across * w[u] / std::sqrt(lengths);
    const float least = wanted > kShortest ? wanted : kShortest;
    scale[u] = (read & plane & (wanted < 1)) ? least : 1.0F;
  }
}

}  // namespace kernels

namespace {

// Rows that are worked on together, so that inverse depths are in the cache; few compared with the rows around them.
constexpr int kRows = 16;

void scale_rows(const KernelFrame& frame, float across, int begin, int end, float* scale) {
  const auto width = static_cast<std::size_t>(frame.width);
  const int first = begin - kReach_px;
  std::vector<float> inverse(static_cast<std::size_t>(end + kReach_px - first) * width);
  const auto row_of = [&](int v) { return inverse.data() + static_cast<std::size_t>(v - first) * width; };
  for (int v = first; v < end + kReach_px; ++v) {
    kernels::invert_row(frame.depth + static_cast<std::size_t>(v) * width, frame.width, row_of(v));
  }
  for (int v = begin; v < end; ++v) {
    kernels::GrazingRow row{};
    for (int r = -kReach_px; r <= kReach_px; ++r) row.inverse[r + kReach_px] = row_of(v + r);
    row.scale = scale + static_cast<std::size_t>(v) * width;
    row.width = frame.width;
    row.fx = frame.fx;
    row.fy = frame.fy;
    row.cx = frame.cx;
    row.y = (static_cast<float>(v) - frame.cy) / frame.fy;
    row.across = across;
    kernels::scale_row(row);
  }
}

}  // namespace

void grazing_scales(const KernelFrame& frame, const Band& band, float voxel_size_m, std::vector<float>& scale) {
  scale.assign(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height) + 1, 1.0F);
  if (frame.width <= 2 * kReach_px || frame.height <= 2 * kReach_px) return;
  const float across = band.truncation_m / (kLeastAcross_voxels * voxel_size_m);
  const int rows = frame.height - 2 * kReach_px;
  parallel_for(static_cast<std::size_t>((rows + kRows - 1) / kRows), [&](std::size_t n) {
    const int begin = kReach_px + static_cast<int>(n) * kRows;
    scale_rows(frame, across, begin, std::min(begin + kRows, frame.height - kReach_px), scale.data());
  });
}

}  // namespace panoptic
