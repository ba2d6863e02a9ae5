// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The voxels of a block, spread out for tests to look at and to change.
#pragma once

#include <memory>

#include "panoptic/map/brick_pool.h"
#include "panoptic/voxel_block.h"

namespace panoptic::test {

inline BlockPlanes planes_of(const VoxelBlock& block) {
  BlockPlanes planes;
  block.unpack(planes);
  return planes;
}

// Changes are in the block when this goes out of scope.
class BlockEdit {
 public:
  explicit BlockEdit(VoxelBlock& block) : block_(block), planes_(std::make_unique<BlockPlanes>()) { block.unpack(*planes_); }
  ~BlockEdit() { block_.pack(*planes_); }
  BlockEdit(const BlockEdit&) = delete;
  BlockEdit& operator=(const BlockEdit&) = delete;

  BlockPlanes& operator*() { return *planes_; }
  BlockPlanes* operator->() { return planes_.get(); }

 private:
  VoxelBlock& block_;
  std::unique_ptr<BlockPlanes> planes_;
};

}  // namespace panoptic::test
