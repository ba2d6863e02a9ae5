// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
// The paper's way: every pixel updates the voxels along its ray (section III-D).
#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/ray_fusion.h"
#include "panoptic/map/block_key.h"
#include "panoptic/parallel.h"

namespace panoptic {

// Collects, for each chunk of rows and each block, the voxels that rays pass through, in the order of the pixels.
void Integrator::touch_rays(const FrameView& view, const VoxelMap& map) {
  ray_table_.resize(view.index(0, view.pixels.height));
  const RayBand band{band_, map.voxel_size_m()};
  const auto row = [&](std::size_t chunk) {
    return static_cast<int>(static_cast<std::size_t>(view.pixels.height) * chunk / kChunks);
  };
  parallel_for(kChunks, [&](std::size_t chunk) {
    PassageLists& lists = rays_[chunk];
    lists.clear();
    collect_passages(view, {row(chunk), row(chunk + 1)}, band, ray_table_, lists);
    keys_[chunk].assign(lists.keys().begin(), lists.keys().end());
  });
}

// It takes up the passages through it, chunk by chunk in the order of the pixels.
void Integrator::update_block_by_rays(const FrameView& view, BlockIndex index, VoxelBlock& block) const {
  const Vec3f place(static_cast<float>(index.x), static_cast<float>(index.y), static_cast<float>(index.z));
  std::array<Passages, kChunks> passages;
  for (std::size_t chunk = 0; chunk < kChunks; ++chunk) passages[chunk] = rays_[chunk].passages(pack(index));
  fuse_passages(view, ray_table_, {band_, voxel_size_m_}, passages, {block, place * kBlockSide});
}

// One block = one task.
void Integrator::update_by_rays(const FrameView& view, std::span<const Slot> slots, VoxelMap& map) {
  parallel_for(slots.size(), [&](std::size_t i) { update_block_by_rays(view, map.index_of(slots[i]), map.block(slots[i])); });
}

}  // namespace panoptic
