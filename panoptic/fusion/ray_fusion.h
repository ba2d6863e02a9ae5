// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Fuses the rays of a frame into the voxels of one block (Eq. 6-11).
#pragma once

#include <cstdint>
#include <span>

#include "panoptic/fusion/frame_view.h"
#include "panoptic/fusion/ray_kernels.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

struct RayTarget {
  VoxelBlock& block;
  Vec3f first_voxel;  // where voxel (0, 0, 0) of the block lies, in voxels
};

// Fuses the passages of one block, list by list, each in its order; the labels alone if the view says so. The lists are as
// PassageLists gives them.
using Passages = std::span<const std::uint16_t>;
void fuse_passages(const FrameView& view, const RayTable& rays, const RayBand& band, std::span<const Passages> lists,
                   const RayTarget& target);

}  // namespace panoptic
