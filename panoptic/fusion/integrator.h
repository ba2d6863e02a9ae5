// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Integrates depth, colour and labels into the voxel map (Eq. 6-11).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/frame.h"
#include "panoptic/fusion/depth_tiles.h"
#include "panoptic/fusion/frame_view.h"
#include "panoptic/fusion/ray_kernels.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/options.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

Fields fields(IntegratorOptions& options);

// Three steps without a lock: find the blocks that the frame concerns (parallel over pixels), allocate them (one thread, in the
// order of their keys), update them (parallel, one block = one task). A block's updates have one fixed order, so the map is the
// same bit for bit at any thread count.
class Integrator {
 public:
  // Panoptic ids from first_object on are objects (LabelSet::first_thing).
  Integrator(const IntegratorOptions& options, const VoxelMap& map, std::uint16_t first_object = 65535);

  // Refuses a frame whose depth would touch more blocks than a surface in view can, before any block is allocated, whichever the
  // method.
  Outcome check_extent(const Frame& frame, const RegisteredFrame& registered, const VoxelMap& map);

  // Integrates a frame; `labels` as LabelTracker::assign returns them. Starts a new epoch and marks the blocks it updates.
  // Depth points beyond the range of block indices (400 km at 2.4 cm) are left out.
  void integrate(const Frame& frame, const RegisteredFrame& registered, std::span<const LabelSlot> labels, VoxelMap& map);

  // Integrates the labels of a frame whose depth and colour were integrated before, with labels that said nothing: the two
  // calls leave the same map, bit for bit, as one call with everything. Changes label, label weight and sum of votes alone (Eq.
  // 9-11). Without that earlier call, labels would have no weight of distance to stand on; blocks that do not exist are left
  // out.
  void integrate_labels(const Frame& frame, const RegisteredFrame& registered, std::span<const LabelSlot> labels, VoxelMap& map);

 private:
  // Rows of pixels are worked in this many chunks: fixed, so that nothing depends on the thread count.
  static constexpr std::size_t kChunks = 32;

  FrameView view_of(const Frame& frame, const RegisteredFrame& registered, std::span<const LabelSlot> labels) const;
  void touch(const FrameView& view, const VoxelMap& map);
  void touch_rays(const FrameView& view, const VoxelMap& map);
  std::vector<Slot> mark_touched(VoxelMap& map, std::vector<std::uint64_t>* absent) const;
  std::vector<Slot> allocate(VoxelMap& map) const;
  void update(const FrameView& view, std::span<const Slot> slots, VoxelMap& map);
  void update_by_projection(FrameView view, std::span<const Slot> slots, VoxelMap& map);
  void update_by_rays(const FrameView& view, std::span<const Slot> slots, VoxelMap& map);
  void update_block_by_rays(const FrameView& view, BlockIndex index, VoxelBlock& block) const;

  bool raycast_;
  bool grazing_;
  Band band_;
  float voxel_size_m_;
  float max_weight_;
  LabelVotes votes_;
  std::vector<float> scale_;  // of signed distances, by pixel
  DepthTiles depth_tiles_;
  std::array<std::vector<std::uint64_t>, kChunks> keys_;  // per chunk: the blocks that it touches
  RayTable ray_table_;
  std::array<PassageLists, kChunks> rays_;  // per chunk: for each block, the voxels that its rays pass through
};

}  // namespace panoptic
