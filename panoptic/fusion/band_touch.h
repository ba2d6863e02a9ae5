// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the blocks that a frame concerns: those that the truncation band around its surface lies in.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/fusion/frame_view.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// Fills each list with the keys (pack in block_key.h) of the blocks that its share of the rows touches; a key may occur more
// than once. Rows run in parallel, one list = one task: the keys depend on the number of lists, not on that of threads.
void touch_bands(const FrameView& view, const Band& band, float block_m, std::span<std::vector<std::uint64_t>> keys);

}  // namespace panoptic
