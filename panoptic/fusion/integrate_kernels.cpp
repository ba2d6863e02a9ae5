// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/integrate_kernels.h"

#include <cmath>
#include <cstddef>
#include <cstring>

#include "panoptic/base/clones.h"
#include "panoptic/fusion/fuse_row.h"

namespace panoptic {
namespace {

using kernels::kRow;
constexpr int kSlice = kRow * kRow;

// A slice of 16 x 16 voxels on its way to the pixels: plain arrays, and nothing but ternaries in the loops, so that each loop
// vectorises by itself. Long loops of loads and of prefetches hide how far away the images are.
struct SliceScratch {
  alignas(64) float x[kSlice];
  alignas(64) float y[kSlice];
  alignas(64) float z[kSlice];
  alignas(64) float inverse_z[kSlice];
  alignas(64) std::int32_t pixel[kSlice];
  alignas(64) float depth[kSlice];
  alignas(64) std::uint8_t near[kSlice];  // 1 = may be in the band
};

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

void integrate_slices(const KernelFrame& frame, const BlockInCamera& place, const Band& band, VoxelBlock& block);
void integrate_label_slices(const KernelFrame& frame, const BlockInCamera& place, const Band& band, VoxelBlock& block);

// Where the voxels of a slice are and which pixels they fall on.
[[gnu::always_inline]] static inline void project_slice(const KernelFrame& frame, const BlockInCamera& place, int slice,
                                                        SliceScratch& s) {
  const auto width = static_cast<float>(frame.width);
  const auto height = static_cast<float>(frame.height);
  const std::int32_t outside = frame.width * frame.height;
  const auto iz = static_cast<float>(slice);
  for (int k = 0; k < kSlice; ++k) {
    const auto ix = static_cast<float>(k & (kRow - 1));
    const auto iy = static_cast<float>(k / kRow);
    const float x = place.origin[0] + iy * place.step_y[0] + iz * place.step_z[0] + ix * place.step_x[0];
    const float y = place.origin[1] + iy * place.step_y[1] + iz * place.step_z[1] + ix * place.step_x[1];
    const float z = place.origin[2] + iy * place.step_y[2] + iz * place.step_z[2] + ix * place.step_x[2];
    const float inverse = 1.0F / z;
    const float u = frame.fx * x * inverse + frame.cx + 0.5F;
    const float v = frame.fy * y * inverse + frame.cy + 0.5F;
    const bool inside = (z > 0) & (u >= 0) & (u < width) & (v >= 0) & (v < height);
    const auto ui = static_cast<std::int32_t>(inside ? u : 0.0F);
    const auto vi = static_cast<std::int32_t>(inside ? v : 0.0F);
    s.pixel[k] = inside ? vi * frame.width + ui : outside;
    s.x[k] = x;
    s.y[k] = y;
    s.z[k] = z;
    s.inverse_z[k] = inverse;
  }
}

// Which voxels could be in the band? The signed distance along the ray is never shorter than that along z; `reach` is a little
// more than the band, for rounding.
[[gnu::always_inline]] static inline void find_near(const KernelFrame& frame, float reach, SliceScratch& s) {
  for (int k = 0; k < kSlice; ++k) s.depth[k] = frame.depth[s.pixel[k]];
  for (int k = 0; k < kSlice; ++k) {
    const float along_z = s.depth[k] - s.z[k];
    s.near[k] = ((s.depth[k] > 0) & (along_z < reach) & (along_z > -reach)) ? 1 : 0;
  }
}

[[gnu::always_inline]] static inline bool any_near(const SliceScratch& s, int row) {
  std::uint64_t half[2];
  std::memcpy(half, s.near + row * kRow, sizeof half);
  return (half[0] | half[1]) != 0;
}

[[gnu::always_inline]] static inline void prefetch_row(const KernelFrame& frame, const SliceScratch& s, int row) {
#pragma GCC unroll 1
  for (int k = row * kRow; k < (row + 1) * kRow; ++k) {
    __builtin_prefetch(frame.color + s.pixel[k]);
    __builtin_prefetch(frame.label + s.pixel[k]);
  }
}

[[gnu::always_inline]] static inline void weigh(const KernelFrame& frame, const Band& band, const SliceScratch& s, int row,
                                                RowScratch& r) {
  const int first = row * kRow;
  for (int k = 0; k < kRow; ++k) {
    const int i = first + k;
    const float range_per_z = std::sqrt(s.x[i] * s.x[i] + s.y[i] * s.y[i] + s.z[i] * s.z[i]) * s.inverse_z[i];
    const float distance = (s.depth[i] - s.z[i]) * range_per_z;
    const bool use = (s.depth[i] > 0) & (distance < band.truncation_m) & (distance > -band.truncation_m);
    const float weight = observation_weight(use ? s.depth[i] : 1.0F, distance, band);
    r.distance[k] = distance;
    r.weight[k] = use ? weight : 0.0F;
  }
#pragma GCC unroll 1
  for (int k = 0; k < kRow; ++k) {
    r.color[k] = frame.color[s.pixel[first + k]];
    r.label[k] = number(frame.label[s.pixel[first + k]]);
  }
}

template <bool LabelsOnly>
[[gnu::always_inline]] static inline void fuse_slices(const KernelFrame& frame_in, const BlockInCamera& place_in,
                                                      const Band& band_in, VoxelBlock& block) {
  const KernelFrame frame = frame_in;  // copies: no store can change them, so they stay in registers
  const BlockInCamera place = place_in;
  const Band band = band_in;
  const RowRules rules{frame.votes, frame.max_weight};
  const float reach = band.truncation_m * 1.001F;
  SliceScratch s;  // NOLINT(cppcoreguidelines-pro-type-member-init): every slice fills it
  RowScratch r;    // NOLINT(cppcoreguidelines-pro-type-member-init): every row fills it
  for (int slice = 0; slice < kRow; ++slice) {
    project_slice(frame, place, slice, s);
    find_near(frame, reach, s);
    for (int row = 0; row < kRow; ++row) {
      if (any_near(s, row)) prefetch_row(frame, s, row);
    }
    for (int row = 0; row < kRow; ++row) {
      if (!any_near(s, row)) continue;
      weigh(frame, band, s, row, r);
      const auto first = static_cast<std::size_t>(slice * kSlice + row * kRow);
      if constexpr (LabelsOnly) {
        fuse_labels(block, first, rules, r);
      } else {
        fuse_row(block, first, rules, r);
      }
    }
  }
}

PANOPTIC_CLONES
void integrate_slices(const KernelFrame& frame, const BlockInCamera& place, const Band& band, VoxelBlock& block) {
  fuse_slices<false>(frame, place, band, block);
}

PANOPTIC_CLONES
void integrate_label_slices(const KernelFrame& frame, const BlockInCamera& place, const Band& band, VoxelBlock& block) {
  fuse_slices<true>(frame, place, band, block);
}

}  // namespace kernels

void integrate_block(const KernelFrame& frame, const BlockInCamera& place, const Band& band, VoxelBlock& block) {
  if (frame.labels_only) {
    kernels::integrate_label_slices(frame, place, band, block);
  } else {
    kernels::integrate_slices(frame, place, band, block);
  }
}

}  // namespace panoptic
