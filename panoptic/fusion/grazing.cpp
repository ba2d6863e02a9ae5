// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/grazing.h"

#include <array>
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

// Five rows of depth, the middle one to be worked on, and the cameras' numbers for it.
struct GrazingRow {
  const float* depth[2 * kReach_px + 1];
  float* scale;
  int width;
  float fx, fy, cx;
  float y;       // of the row, at depth 1
  float across;  // the truncation over the least reach across the surface
};

void scale_row(const GrazingRow& row_in);

// A plane is linear in inverse depth: w = n . (x, y, 1) with the plane n . p = 1, and the cosine of the view is
// w / (|n| |(x, y, 1)|).
PANOPTIC_CLONES
void scale_row(const GrazingRow& row_in) {
  const GrazingRow row = row_in;
  const float* __restrict z = row.depth[kReach_px];
  const float* __restrict far_above = row.depth[0];
  const float* __restrict above = row.depth[1];
  const float* __restrict below = row.depth[3];
  const float* __restrict far_below = row.depth[4];
  float* __restrict scale = row.scale;
  constexpr float kBent = 0.5F;  // of the slope; at a step it is 1
  constexpr float kShortest = 1.0F / kLongestBand;
  for (int u = kReach_px; u < row.width - kReach_px; ++u) {
    const bool read = (z[u] > 0) & (z[u - 1] > 0) & (z[u + 1] > 0) & (z[u - 2] > 0) & (z[u + 2] > 0) & (above[u] > 0) &
                      (below[u] > 0) & (far_above[u] > 0) & (far_below[u] > 0);
    const float w = 1.0F / z[u];
    const float left = 1.0F / z[u - 2];
    const float right = 1.0F / z[u + 2];
    const float top = 1.0F / far_above[u];
    const float bottom = 1.0F / far_below[u];
    const float du = right - left;
    const float dv = bottom - top;
    const float near_du = 1.0F / z[u + 1] - 1.0F / z[u - 1];
    const float near_dv = 1.0F / below[u] - 1.0F / above[u];
    const float slope = std::abs(du) > std::abs(dv) ? std::abs(du) : std::abs(dv);
    const float bent = kBent * slope;
    const float far_bend_u = std::abs(left + right - 2 * w);
    const float far_bend_v = std::abs(top + bottom - 2 * w);
    const float near_bend_u = std::abs(2 * near_du - du);
    const float near_bend_v = std::abs(2 * near_dv - dv);
    const bool plane = (far_bend_u <= bent) & (far_bend_v <= bent) & (near_bend_u <= bent) & (near_bend_v <= bent);
    const float x = (static_cast<float>(u) - row.cx) / row.fx;
    const float nx = du * row.fx * (0.5F / kReach_px);
    const float ny = dv * row.fy * (0.5F / kReach_px);
    const float nz = w - nx * x - ny * row.y;
    const float lengths = (nx * nx + ny * ny + nz * nz) * (x * x + row.y * row.y + 1);
    const float wanted = row.across * w / std::sqrt(lengths);
    const float least = wanted > kShortest ? wanted : kShortest;
    scale[u] = (read & plane & (wanted < 1)) ? least : 1.0F;
  }
}

}  // namespace kernels

void grazing_scales(const KernelFrame& frame, const Band& band, float voxel_size_m, std::vector<float>& scale) {
  const auto width = static_cast<std::size_t>(frame.width);
  const auto height = static_cast<std::size_t>(frame.height);
  scale.assign(width * height + 1, 1.0F);
  if (frame.width <= 2 * kReach_px || frame.height <= 2 * kReach_px) return;
  parallel_for(height - 2 * kReach_px, [&](std::size_t n) {
    const std::size_t v = n + kReach_px;
    kernels::GrazingRow row{};
    for (std::size_t r = 0; r <= 2 * kReach_px; ++r) row.depth[r] = frame.depth + (n + r) * width;
    row.scale = scale.data() + v * width;
    row.width = frame.width;
    row.fx = frame.fx;
    row.fy = frame.fy;
    row.cx = frame.cx;
    row.y = (static_cast<float>(v) - frame.cy) / frame.fy;
    row.across = band.truncation_m / (kLeastAcross_voxels * voxel_size_m);
    kernels::scale_row(row);
  });
}

}  // namespace panoptic
