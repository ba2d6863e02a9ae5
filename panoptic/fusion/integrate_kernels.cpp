// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/integrate_kernels.h"

#include <cmath>
#include <cstddef>

#include "panoptic/base/clones.h"

namespace panoptic {
namespace {

constexpr std::size_t kRow = kBlockSide;

// A row of 16 voxels on its way through the loops: plain arrays, so that each loop vectorises by itself.
struct RowScratch {
  alignas(64) float z[kRow];
  alignas(64) float range_per_z[kRow];
  alignas(64) std::int32_t pixel[kRow];
  alignas(64) float depth[kRow];
  alignas(64) float distance[kRow];
  alignas(64) float weight[kRow];
};

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

void integrate_rows(const KernelFrame& frame, const BlockInCamera& place, const Band& band, VoxelBlock& block);

PANOPTIC_CLONES
void integrate_rows(const KernelFrame& frame, const BlockInCamera& place, const Band& band, VoxelBlock& block) {
  RowScratch s{};
  const auto width = static_cast<float>(frame.width);
  const auto height = static_cast<float>(frame.height);
  const std::int32_t outside = frame.width * frame.height;
  for (std::size_t row = 0; row < kRow * kRow; ++row) {
    const auto iy = static_cast<float>(row % kRow);
    const auto iz = static_cast<float>(row / kRow);
    const float x0 = place.origin[0] + iy * place.step_y[0] + iz * place.step_z[0];
    const float y0 = place.origin[1] + iy * place.step_y[1] + iz * place.step_z[1];
    const float z0 = place.origin[2] + iy * place.step_y[2] + iz * place.step_z[2];
    for (std::size_t k = 0; k < kRow; ++k) {
      const auto ix = static_cast<float>(static_cast<std::int32_t>(k));
      const float x = x0 + ix * place.step_x[0];
      const float y = y0 + ix * place.step_x[1];
      const float z = z0 + ix * place.step_x[2];
      const float inverse = 1.0F / z;
      const float u = frame.fx * x * inverse + frame.cx + 0.5F;
      const float v = frame.fy * y * inverse + frame.cy + 0.5F;
      const bool inside = (z > 0) & (u >= 0) & (u < width) & (v >= 0) & (v < height);
      const auto ui = static_cast<std::int32_t>(inside ? u : 0.0F);
      const auto vi = static_cast<std::int32_t>(inside ? v : 0.0F);
      s.pixel[k] = inside ? vi * frame.width + ui : outside;
      s.z[k] = z;
      s.range_per_z[k] = std::sqrt(x * x + y * y + z * z) * inverse;
    }
    for (std::size_t k = 0; k < kRow; ++k) s.depth[k] = frame.depth[s.pixel[k]];
    std::int32_t in_band = 0;
    for (std::size_t k = 0; k < kRow; ++k) {
      const float distance = (s.depth[k] - s.z[k]) * s.range_per_z[k];
      const bool use = (s.depth[k] > 0) & (distance < band.truncation_m) & (distance > -band.truncation_m);
      s.distance[k] = distance;
      s.weight[k] = use ? observation_weight(s.depth[k], distance, band) : 0.0F;
      in_band |= use ? 1 : 0;
    }
    if (in_band == 0) continue;
    for (std::size_t k = 0; k < kRow; ++k) {
      if (s.weight[k] <= 0) continue;
      const auto pixel = static_cast<std::size_t>(s.pixel[k]);
      fuse_voxel(block, row * kRow + k, s.distance[k], s.weight[k], frame.color[pixel], frame.label[pixel]);
    }
  }
}

}  // namespace kernels

void integrate_block(const KernelFrame& frame, const BlockInCamera& place, const Band& band, VoxelBlock& block) {
  kernels::integrate_rows(frame, place, band, block);
}

}  // namespace panoptic
