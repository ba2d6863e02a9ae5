// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panoptic/voxel_map.h"

namespace panoptic {

// Looks up voxels near the previous one without hashing again. One per thread; make a new one after blocks were allocated.
class CachedLookup {
 public:
  explicit CachedLookup(const VoxelMap& map) : map_(map) {}

  const VoxelBlock* find(BlockIndex index) {
    if (!valid_ || index != last_) {
      block_ = map_.find(index);
      last_ = index;
      valid_ = true;
    }
    return block_;
  }

 private:
  const VoxelMap& map_;
  BlockIndex last_;
  const VoxelBlock* block_ = nullptr;
  bool valid_ = false;
};

}  // namespace panoptic
