// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/reference_labels.h"

#include "panoptic/base/parallel.h"

namespace panoptic {

void reference_labels(const VoxelMap& map, const Frame& frame, const RegisteredFrame& registered,
                      std::vector<PanopticId>& labels) {
  labels.resize(registered.pixel_count());
  const Camera& camera = frame.depth_camera;
  const double per_metre = 1.0 / map.voxel_size_m();
  const Eigen::Matrix3f r = (frame.world_from_camera.linear() * per_metre).cast<float>();
  const Vec3f t = (frame.world_from_camera.translation() * per_metre).cast<float>();
  parallel_for(static_cast<std::size_t>(registered.height), [&](std::size_t row) {
    CachedLookup lookup(map);
    const auto y = static_cast<float>((static_cast<double>(row) - camera.cy) / camera.fy);
    const Vec3f base = r.col(1) * y + r.col(2);
    const std::size_t begin = row * static_cast<std::size_t>(registered.width);
    for (int u = 0; u < registered.width; ++u) {
      const std::size_t i = begin + static_cast<std::size_t>(u);
      labels[i] = PanopticId::kUnknown;
      const float z = registered.depth[i];
      if (z <= 0) continue;
      const auto x = static_cast<float>((u - camera.cx) / camera.fx);
      const Vec3f voxel = (r.col(0) * x + base) * z + t;
      const auto vx = floor_to_int(voxel.x());
      const auto vy = floor_to_int(voxel.y());
      const auto vz = floor_to_int(voxel.z());
      const VoxelBlock* block = lookup.find({vx >> 4, vy >> 4, vz >> 4});
      if (block != nullptr) {
        labels[i] = static_cast<PanopticId>(block->label[static_cast<std::size_t>(voxel_offset(vx & 15, vy & 15, vz & 15))]);
      }
    }
  });
}

}  // namespace panoptic
