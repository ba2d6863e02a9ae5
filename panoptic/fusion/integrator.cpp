// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/integrator.h"

#include <algorithm>

#include "panoptic/base/parallel.h"
#include "panoptic/fusion/band_touch.h"

namespace panoptic {
Fields fields(IntegratorOptions& o) {
  return {{"method", &o.method, "projective: voxels look up pixels (fast); raycast: pixels walk their rays (the paper)",
           one_of({"projective", "raycast"})},
          {"object_vote", &o.object_vote, "how much a pixel of an object counts, where others count 1", in_range(0, 100)}};
}

Integrator::Integrator(const IntegratorOptions& options, const VoxelMap& map, std::uint16_t first_object)
    : raycast_(options.method == "raycast"),
      band_{map.truncation_m(), map.voxel_size_m()},
      votes_{options.object_vote, first_object} {}

void Integrator::integrate(const Frame& frame, const RegisteredFrame& registered, std::span<const PanopticId> labels,
                           VoxelMap& map) {
  const Camera& c = frame.depth_camera;
  const FrameView view{
      {registered.depth.data(), registered.color.data(), labels.data(), registered.width, registered.height,
       static_cast<float>(c.fx), static_cast<float>(c.fy), static_cast<float>(c.cx), static_cast<float>(c.cy), votes_},
      c,
      frame.world_from_camera.linear().cast<float>(),
      frame.world_from_camera.translation(),
      registered.farthest_m};
  map.begin_epoch();
  if (raycast_) {
    touch_rays(view, map);
    update_by_rays(view, allocate(map), map);
  } else {
    touch_bands(view, band_, map.block_size_m(), keys_);
    update_by_projection(view, allocate(map), map);
  }
}

// The slots of all touched blocks, each once. New blocks are allocated in ascending order of their keys.
std::vector<Slot> Integrator::allocate(VoxelMap& map) {
  std::vector<Slot> slots;
  std::vector<std::uint64_t> absent;
  const auto add = [&](Slot slot) {
    map.mark_changed(slot);
    slots.push_back(slot);
  };
  for (const std::vector<std::uint64_t>& chunk : keys_) {
    for (const std::uint64_t key : chunk) {
      const Slot slot = map.find_slot(unpack(key));
      if (slot == VoxelMap::kNoSlot) {
        absent.push_back(key);
      } else if (map.changed_at(slot) != map.epoch()) {
        add(slot);
      }
    }
  }
  std::sort(absent.begin(), absent.end());
  absent.erase(std::unique(absent.begin(), absent.end()), absent.end());
  for (const std::uint64_t key : absent) add(map.allocate(unpack(key)));
  return slots;
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
