// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/integrate_kernels.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "panoptic/base/clones.h"
#include "panoptic/fusion/flags.h"
#include "panoptic/fusion/fuse_brick.h"
#include "panoptic/fusion/project_brick.h"

namespace panoptic {
namespace {

constexpr int kTogether = 2;  // bricks
constexpr int kSlice = kBrickSide * kBrickSide;

// Some bricks on their way to the pixels: plain arrays, and nothing but ternaries in the loops, so that each loop vectorises by
// itself. Long loops of loads and of prefetches hide how far away the images are.
struct BricksScratch {
  static constexpr int kVoxels = kTogether * kBrickVoxels;
  alignas(64) float x[kVoxels];
  alignas(64) float y[kVoxels];
  alignas(64) float z[kVoxels];
  alignas(64) float inverse_z[kVoxels];
  alignas(64) std::int32_t pixel[kVoxels];
  alignas(64) float depth[kVoxels];
  alignas(64) float scale[kVoxels];
  alignas(64) std::uint8_t near[kVoxels];  // 1 = may be in the band
  alignas(64) float distance[kBrickVoxels];
  alignas(64) float weight[kBrickVoxels];
};

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

void integrate_bricks(const KernelFrame& frame, const BlockInCamera& place, const Band& band, std::uint64_t bricks,
                      VoxelBlock& block);
void integrate_grazing_bricks(const KernelFrame& frame, const BlockInCamera& place, const Band& band, std::uint64_t bricks,
                              VoxelBlock& block);
void integrate_label_bricks(const KernelFrame& frame, const BlockInCamera& place, const Band& band, std::uint64_t bricks,
                            VoxelBlock& block);
void integrate_grazing_label_bricks(const KernelFrame& frame, const BlockInCamera& place, const Band& band, std::uint64_t bricks,
                                    VoxelBlock& block);

// Which voxels could be in the band? The signed distance along the ray is never shorter than that along z; `reach` is a little
// more than the band, for rounding.
template <bool Grazing>
[[gnu::always_inline]] static inline void find_near(const KernelFrame& frame, float reach, int bricks, BricksScratch& s) {
  for (int k = 0; k < bricks * kBrickVoxels; ++k) s.depth[k] = frame.depth[s.pixel[k]];
  for (int k = 0; k < bricks * kBrickVoxels; ++k) s.scale[k] = Grazing ? frame.scale[s.pixel[k]] : 1.0F;
  for (int k = 0; k < bricks * kBrickVoxels; ++k) {
    const float along_z = (s.depth[k] - s.z[k]) * s.scale[k];
    s.near[k] = ((s.depth[k] > 0) & (along_z < reach) & (along_z > -reach)) ? 1 : 0;
  }
}

[[gnu::always_inline]] static inline bool any_near(const BricksScratch& s, int slice) {
  std::uint64_t half[2];
  std::memcpy(half, s.near + slice * kSlice, sizeof half);
  return (half[0] | half[1]) != 0;
}

[[gnu::always_inline]] static inline void prefetch_slice(const KernelFrame& frame, const BricksScratch& s, int slice) {
#pragma GCC unroll 1
  for (int k = slice * kSlice; k < (slice + 1) * kSlice; ++k) {
    __builtin_prefetch(frame.color + s.pixel[k]);
    __builtin_prefetch(frame.label + s.pixel[k]);
  }
}

[[gnu::always_inline]] static inline void prefetch_planes(const Brick& brick) {
  constexpr int kLine = 64;
  const int bytes = brick.capacity() * kVoxelBytes;
#pragma GCC unroll 1
  for (int at = 0; at < bytes; at += kLine) __builtin_prefetch(brick.planes() + at);
}

// Distance and weight for the voxels of the brick that begins at `first`. Returns a bit for every one that is observed.
[[gnu::always_inline]] static inline std::uint64_t weigh(const KernelFrame& frame, const Band& band, int first,
                                                         BricksScratch& s) {
  alignas(64) std::uint8_t observed[kBrickVoxels];
  for (int k = 0; k < kBrickVoxels; ++k) {
    const int i = first + k;
    const float range_per_z = std::sqrt(s.x[i] * s.x[i] + s.y[i] * s.y[i] + s.z[i] * s.z[i]) * s.inverse_z[i];
    const float distance = (s.depth[i] - s.z[i]) * range_per_z * s.scale[i];
    const bool use = (s.depth[i] > 0) & (distance < band.truncation_m) & (distance > -band.truncation_m);
    const float weight = observation_weight(use ? s.depth[i] : 1.0F, distance, band);
    s.distance[k] = distance;
    s.weight[k] = use ? weight : 0.0F;
  }
  if (frame.depth_weight != nullptr) {
    for (int k = 0; k < kBrickVoxels; ++k) s.weight[k] *= frame.depth_weight[s.pixel[first + k]];
  }
  for (int k = 0; k < kBrickVoxels; ++k) observed[k] = s.weight[k] > 0 ? 1 : 0;
  return bits_of(observed);
}

// The observations of all voxels of a brick.
[[gnu::always_inline]] static inline void gather_all(const KernelFrame& frame, int first, const BricksScratch& s,
                                                     BrickObservations& o) {
  for (int k = 0; k < kBrickVoxels; ++k) {
    o.distance[k] = s.distance[k];
    o.weight[k] = s.weight[k];
  }
  for (int k = 0; k < kBrickVoxels; ++k) o.color[k] = frame.color[s.pixel[first + k]];
  for (int k = 0; k < kBrickVoxels; ++k) o.label[k] = number(frame.label[s.pixel[first + k]]);
}

// The observations of the voxels that the brick stores.
[[gnu::always_inline]] static inline void gather(const KernelFrame& frame, const Brick& brick, int first, const BricksScratch& s,
                                                 BrickObservations& o) {
  int k = 0;
  for (std::uint64_t rest = brick.stored(); rest != 0; rest &= rest - 1, ++k) {
    const int voxel = std::countr_zero(rest);
    const std::int32_t pixel = s.pixel[first + voxel];
    o.distance[k] = s.distance[voxel];
    o.weight[k] = s.weight[voxel];
    o.color[k] = frame.color[pixel];
    o.label[k] = number(frame.label[pixel]);
  }
  for (; k < brick.capacity(); ++k) {
    o.distance[k] = 0;
    o.weight[k] = 0;
    o.color[k] = 0;
    o.label[k] = number(LabelSlot::kNoVote);
  }
}

template <bool LabelsOnly>
[[gnu::always_inline]] static inline void fuse_observed(const KernelFrame& frame, const Band& band, int number, int first,
                                                        BricksScratch& s, VoxelBlock& block) {
  const FusionRules rules{frame.votes, frame.max_weight};
  BrickObservations o;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled as far as it is read
  const std::uint64_t observed = weigh(frame, band, first, s);
  Brick& brick = block.brick(number);
  if constexpr (LabelsOnly) {
    if ((observed & brick.stored()) == 0) return;
  } else {
    if (observed == 0) return;
    if ((observed & ~brick.stored()) != 0) block.store(number, observed);
  }
  if (brick.stored() == ~std::uint64_t{0}) {
    gather_all(frame, first, s, o);
  } else {
    gather(frame, brick, first, s, o);
  }
  if constexpr (LabelsOnly) {
    fuse_labels(brick, brick.capacity(), rules, o);
  } else {
    fuse_brick(brick, brick.capacity(), rules, o);
  }
}

template <bool LabelsOnly, bool Grazing>
[[gnu::always_inline]] static inline void fuse_bricks(const KernelFrame& frame_in, const BlockInCamera& place_in,
                                                      const Band& band_in, std::uint64_t bricks, VoxelBlock& block) {
  const KernelFrame frame = frame_in;  // copies: no store can change them, so they stay in registers
  const BlockInCamera place = place_in;
  const Band band = band_in;
  const float reach = band.truncation_m * 1.001F;
  BricksScratch s;  // NOLINT(cppcoreguidelines-pro-type-member-init): every turn fills it
  while (bricks != 0) {
    int number[kTogether] = {};
    int count = 0;
    for (; count < kTogether && bricks != 0; ++count, bricks &= bricks - 1) number[count] = std::countr_zero(bricks);
    for (int n = 0; n < count; ++n) project_brick(frame, place, number[n], n * kBrickVoxels, s);
    find_near<Grazing>(frame, reach, count, s);
    for (int slice = 0; slice < count * kBrickSide; ++slice) {
      if (any_near(s, slice)) prefetch_slice(frame, s, slice);
    }
    for (int n = 0; n < count; ++n) prefetch_planes(block.brick(number[n]));
    for (int n = 0; n < count; ++n) {
      const int first = n * kBrickVoxels;
      if (bits_of(s.near + first) != 0) fuse_observed<LabelsOnly>(frame, band, number[n], first, s, block);
    }
  }
}

PANOPTIC_CLONES
void integrate_bricks(const KernelFrame& frame, const BlockInCamera& place, const Band& band, std::uint64_t bricks,
                      VoxelBlock& block) {
  fuse_bricks<false, false>(frame, place, band, bricks, block);
}

PANOPTIC_CLONES
void integrate_grazing_bricks(const KernelFrame& frame, const BlockInCamera& place, const Band& band, std::uint64_t bricks,
                              VoxelBlock& block) {
  fuse_bricks<false, true>(frame, place, band, bricks, block);
}

PANOPTIC_CLONES
void integrate_label_bricks(const KernelFrame& frame, const BlockInCamera& place, const Band& band, std::uint64_t bricks,
                            VoxelBlock& block) {
  fuse_bricks<true, false>(frame, place, band, bricks, block);
}

PANOPTIC_CLONES
void integrate_grazing_label_bricks(const KernelFrame& frame, const BlockInCamera& place, const Band& band, std::uint64_t bricks,
                                    VoxelBlock& block) {
  fuse_bricks<true, true>(frame, place, band, bricks, block);
}

}  // namespace kernels

void integrate_block(const KernelFrame& frame, const BlockInCamera& place, const Band& band, const BricksInBand& bricks,
                     VoxelBlock& block) {
  if (frame.labels_only) {
    (bricks.grazing ? kernels::integrate_grazing_label_bricks : kernels::integrate_label_bricks)(frame, place, band,
                                                                                                 bricks.bricks, block);
  } else {
    (bricks.grazing ? kernels::integrate_grazing_bricks : kernels::integrate_bricks)(frame, place, band, bricks.bricks, block);
  }
}

}  // namespace panoptic
