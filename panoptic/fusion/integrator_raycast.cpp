// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
// The paper's way: every pixel updates the voxels along its ray (section III-D).
#include <algorithm>
#include <cmath>

#include "panoptic/base/parallel.h"
#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/ray_walk.h"

namespace panoptic {
namespace {

// The part of a pixel's ray within the band, in units of voxels; and the direction and range for the signed distance.
struct RaySegment {
  Vec3f begin;
  Vec3f end;
  Vec3f direction;  // unit length
  Vec3f origin;     // the camera
  float range = 0;  // from the camera to the surface
};

RaySegment segment_of(const FrameView& view, std::uint32_t pixel, const Band& band, float voxel_size_m) {
  const int u = static_cast<int>(pixel) % view.pixels.width;
  const int v = static_cast<int>(pixel) / view.pixels.width;
  const Vec3f to_surface = view.ray(u, v) * (view.pixels.depth[pixel] / voxel_size_m);
  RaySegment segment;
  segment.range = to_surface.norm();
  segment.direction = to_surface / segment.range;
  segment.origin = (view.camera_in_world_m / double{voxel_size_m}).cast<float>();
  const Vec3f surface = segment.origin + to_surface;
  const Vec3f half_band = segment.direction * (band.truncation_m / voxel_size_m);
  segment.begin = surface - half_band;
  segment.end = surface + half_band;
  return segment;
}

bool within_grid(const RaySegment& s) {
  constexpr auto kLimit = static_cast<float>((kMaxBlockCoordinate - 2) * kBlockSide);
  return s.begin.cwiseAbs().maxCoeff() < kLimit && s.end.cwiseAbs().maxCoeff() < kLimit;
}

std::uint64_t block_key(std::int32_t x, std::int32_t y, std::int32_t z) { return pack({x >> 4, y >> 4, z >> 4}); }

struct BlockTarget {
  VoxelBlock& block;
  std::uint64_t key;
  float voxel_size_m;
};

// Updates the voxels of one block along the ray of a pixel.
void fuse_along_ray(const FrameView& view, std::uint32_t pixel, const Band& band, const BlockTarget& target) {
  const RaySegment s = segment_of(view, pixel, band, target.voxel_size_m);
  walk_cells(s.begin, s.end, [&](std::int32_t x, std::int32_t y, std::int32_t z) {
    if (block_key(x, y, z) != target.key) return;
    const Vec3f center = Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) + Vec3f::Constant(0.5F);
    const float along = (s.range - s.direction.dot(center - s.origin)) * target.voxel_size_m;
    const float distance = std::clamp(along, -band.truncation_m, band.truncation_m);
    const float weight = observation_weight(view.pixels.depth[pixel], distance, band);
    if (weight <= 0) return;
    const auto voxel = static_cast<std::size_t>(voxel_offset(x & 15, y & 15, z & 15));
    fuse_voxel(target.block, voxel, distance, weight, view.pixels.color[pixel], view.pixels.label[pixel]);
  });
}

}  // namespace

// For each chunk and block, the pixels whose rays cross the block, in the order of the pixels.
void Integrator::touch_rays(const FrameView& view, const VoxelMap& map) {
  const auto pixels = static_cast<std::size_t>(view.pixels.width) * static_cast<std::size_t>(view.pixels.height);
  parallel_for(kChunks, [&](std::size_t chunk) {
    PixelsOfBlock& lists = rays_[chunk];
    for (auto& [key, list] : lists) list.clear();
    keys_[chunk].clear();
    const auto begin = static_cast<std::uint32_t>(pixels * chunk / kChunks);
    const auto end = static_cast<std::uint32_t>(pixels * (chunk + 1) / kChunks);
    for (std::uint32_t pixel = begin; pixel < end; ++pixel) {
      if (view.pixels.depth[pixel] <= 0) continue;
      const RaySegment segment = segment_of(view, pixel, band_, map.voxel_size_m());
      if (!within_grid(segment)) continue;
      std::uint64_t last = ~std::uint64_t{0};
      walk_cells(segment.begin, segment.end, [&](std::int32_t x, std::int32_t y, std::int32_t z) {
        const std::uint64_t key = block_key(x, y, z);
        if (key != last) lists[key].push_back(pixel);
        last = key;
      });
    }
    std::erase_if(lists, [](const auto& entry) { return entry.second.empty(); });
    for (const auto& [key, list] : lists) keys_[chunk].push_back(key);
  });
}

// One block = one task: it walks the rays that cross it, chunk by chunk in the order of the pixels, and keeps what is inside.
void Integrator::update_by_rays(const FrameView& view, std::span<const Slot> slots, VoxelMap& map) {
  parallel_for(slots.size(), [&](std::size_t i) {
    const BlockTarget target{map.block(slots[i]), pack(map.index_of(slots[i])), map.voxel_size_m()};
    for (const PixelsOfBlock& lists : rays_) {
      const auto list = lists.find(target.key);
      if (list == lists.end()) continue;
      for (const std::uint32_t pixel : list->second) fuse_along_ray(view, pixel, band_, target);
    }
  });
}

}  // namespace panoptic
