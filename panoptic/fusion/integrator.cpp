// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/integrator.h"

#include <algorithm>
#include <cmath>

#include "panoptic/base/parallel.h"

namespace panoptic {
namespace {

// Pixels sampled when looking for blocks: at 8 m they are 3 cm apart, a block is 38 cm (16 cm at voxels of 1 cm) wide.
constexpr int kTouchStride_px = 2;

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
    touch_bands(view, map);
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

// Samples the band around each sampled pixel's surface point, at steps shorter than a block.
void Integrator::touch_bands(const FrameView& view, const VoxelMap& map) {
  const float blocks_per_metre = 1.0F / map.block_size_m();
  const Vec3f origin = (view.camera_in_world_m * double{blocks_per_metre}).cast<float>();
  const float band_blocks = 2 * band_.truncation_m * blocks_per_metre;
  const int steps = 1 + static_cast<int>(std::ceil(band_blocks));
  parallel_for(kChunks, [&](std::size_t chunk) {
    RecentKeys recent;
    const int samples = (view.pixels.height + kTouchStride_px - 1) / kTouchStride_px;
    const int begin = samples * static_cast<int>(chunk) / static_cast<int>(kChunks);
    const int end = samples * static_cast<int>(chunk + 1) / static_cast<int>(kChunks);
    for (int v = begin * kTouchStride_px; v < end * kTouchStride_px; v += kTouchStride_px) {
      for (int u = 0; u < view.pixels.width; u += kTouchStride_px) {
        const float z = view.pixels.depth[view.index(u, v)];
        if (z <= 0) continue;
        const Vec3f ray = view.ray(u, v) * blocks_per_metre;
        const Vec3f middle = origin + ray * z;
        if (!within_grid(middle)) continue;
        const Vec3f direction = ray.normalized();
        for (int s = 0; s <= steps; ++s) {
          const Vec3f p = middle + direction * (band_blocks * (static_cast<float>(s) / static_cast<float>(steps) - 0.5F));
          const std::uint64_t key = pack({floor_to_int(p.x()), floor_to_int(p.y()), floor_to_int(p.z())});
          if (!recent.seen(key)) keys_[chunk].push_back(key);
        }
      }
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
