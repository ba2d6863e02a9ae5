// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/integrator.h"

#include <algorithm>
#include <cmath>

#include "panoptic/base/parallel.h"

namespace panoptic {
namespace {

// Every second pixel is enough to find the blocks as long as they are less than half a block apart: at 2.4 cm and 8 m they are
// 3 cm apart and a block is 38 cm wide. Small voxels seen from afar need every pixel (and still find every block only where
// neighbouring pixels are less than a block apart).
int touch_stride_px(float farthest_m, double focal_px, float block_m) {
  constexpr int kStride_px = 2;
  return kStride_px * farthest_m / static_cast<float>(focal_px) < block_m / 2 ? kStride_px : 1;
}

// Block coordinates beyond this are refused before they are turned into integers.
bool within_grid(const Vec3f& block) { return block.cwiseAbs().maxCoeff() < static_cast<float>(kMaxBlockCoordinate - 2); }

// Remembers the keys seen last; neighbouring pixels nearly always touch the same blocks.
class RecentKeys {
 public:
  RecentKeys() { keys_.fill(~std::uint64_t{0}); }

  bool seen(std::uint64_t key) {
    std::uint64_t& place = keys_[mixed(key) % keys_.size()];
    if (place == key) return true;
    place = key;
    return false;
  }

 private:
  std::array<std::uint64_t, 64> keys_{};
};

// What is the same for every pixel of a frame, in blocks instead of metres.
struct BandWalk {
  float blocks_per_metre = 0;
  Vec3f camera = Vec3f::Zero();
  float band_blocks = 0;
  int steps = 0;
  int stride_px = 1;
};

// Samples the band around each sampled pixel's surface point, at steps shorter than a block.
void touch_row(const FrameView& view, int v, const BandWalk& walk, RecentKeys& recent, std::vector<std::uint64_t>& keys) {
  for (int u = 0; u < view.pixels.width; u += walk.stride_px) {
    const float z = view.pixels.depth[view.index(u, v)];
    if (z <= 0) continue;
    const Vec3f ray = view.ray(u, v) * walk.blocks_per_metre;
    const Vec3f middle = walk.camera + ray * z;
    if (!within_grid(middle)) continue;
    const Vec3f direction = ray.normalized();
    for (int s = 0; s <= walk.steps; ++s) {
      const float share = static_cast<float>(s) / static_cast<float>(walk.steps) - 0.5F;
      const Vec3f p = middle + direction * (walk.band_blocks * share);
      const std::uint64_t key = pack({floor_to_int(p.x()), floor_to_int(p.y()), floor_to_int(p.z())});
      if (!recent.seen(key)) keys.push_back(key);
    }
  }
}

}  // namespace

Fields fields(IntegratorOptions& o) {
  return {{"method", &o.method, "projective: voxels look up pixels (fast); raycast: pixels walk their rays (the paper)",
           one_of({"projective", "raycast"})}};
}

Integrator::Integrator(const IntegratorOptions& options, const VoxelMap& map)
    : raycast_(options.method == "raycast"), band_{map.truncation_m(), map.voxel_size_m()} {}

void Integrator::integrate(const Frame& frame, const RegisteredFrame& registered, std::span<const PanopticId> labels,
                           VoxelMap& map) {
  const Camera& c = frame.depth_camera;
  const FrameView view{{registered.depth.data(), registered.color.data(), labels.data(), registered.width, registered.height,
                        static_cast<float>(c.fx), static_cast<float>(c.fy), static_cast<float>(c.cx), static_cast<float>(c.cy)},
                       c,
                       frame.world_from_camera.linear().cast<float>(),
                       frame.world_from_camera.translation()};
  map.begin_epoch();
  if (raycast_) {
    touch_rays(view, map);
    update_by_rays(view, allocate(map), map);
  } else {
    touch_bands(view, touch_stride_px(registered.farthest_m, c.fx, map.block_size_m()), map);
    update_by_projection(view, allocate(map), map);
  }
}

// All touched blocks, allocated in ascending order of their keys.
std::vector<Slot> Integrator::allocate(VoxelMap& map) {
  std::vector<std::uint64_t> all;
  for (std::vector<std::uint64_t>& chunk : keys_) {
    all.insert(all.end(), chunk.begin(), chunk.end());
    chunk.clear();
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  std::vector<Slot> slots;
  slots.reserve(all.size());
  for (const std::uint64_t key : all) {
    slots.push_back(map.allocate(unpack(key)));
    map.mark_changed(slots.back());
  }
  return slots;
}

void Integrator::touch_bands(const FrameView& view, int stride_px, const VoxelMap& map) {
  const float blocks_per_metre = 1.0F / map.block_size_m();
  const float band_blocks = 2 * band_.truncation_m * blocks_per_metre;
  const BandWalk walk{blocks_per_metre, (view.camera_in_world_m * double{blocks_per_metre}).cast<float>(), band_blocks,
                      1 + static_cast<int>(std::ceil(band_blocks)), stride_px};
  parallel_for(kChunks, [&](std::size_t chunk) {
    RecentKeys recent;
    const int samples = (view.pixels.height + stride_px - 1) / stride_px;
    const int begin = samples * static_cast<int>(chunk) / static_cast<int>(kChunks);
    const int end = samples * static_cast<int>(chunk + 1) / static_cast<int>(kChunks);
    for (int v = begin * stride_px; v < end * stride_px; v += stride_px) {
      touch_row(view, v, walk, recent, keys_[chunk]);
    }
  });
}

void Integrator::update_by_projection(const FrameView& view, std::span<const Slot> slots, VoxelMap& map) {
  const Eigen::Matrix3f camera_from_world = view.world_from_camera.transpose();
  const Eigen::Matrix3f step = camera_from_world * map.voxel_size_m();
  parallel_for(slots.size(), [&](std::size_t i) {
    const BlockIndex index = map.index_of(slots[i]);
    const Vec3d first_voxel_m =
        (Vec3d(index.x, index.y, index.z) * kBlockSide + Vec3d::Constant(0.5)) * double{map.voxel_size_m()};
    const Vec3f place = camera_from_world * (first_voxel_m - view.camera_in_world_m).cast<float>();
    BlockInCamera in_camera{};
    for (int a = 0; a < 3; ++a) {
      in_camera.origin[a] = place[a];
      in_camera.step_x[a] = step(a, 0);
      in_camera.step_y[a] = step(a, 1);
      in_camera.step_z[a] = step(a, 2);
    }
    integrate_block(view.pixels, in_camera, band_, map.block(slots[i]));
  });
}

}  // namespace panoptic
