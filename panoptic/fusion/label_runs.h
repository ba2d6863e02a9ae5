// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Neighbouring pixels mostly say the same, so tracking looks at runs of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/labels.h"

namespace panoptic {

// Pixels of one segment for which the map has one label, up to where the next run begins.
struct LabelRun {
  std::uint32_t begin = 0;
  std::uint16_t segment = 0;  // as RegisteredFrame::segment
  LabelSlot reference = LabelSlot::kUnknown;
};

// Fills `runs` with those of the pixels [begin, end), in order, and one more that begins at `end` and says nothing. REQUIRES
// both images to hold these pixels.
struct PixelRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};
void find_runs(std::span<const std::uint16_t> segment, std::span<const LabelSlot> reference, PixelRange pixels,
               std::vector<LabelRun>& runs);

}  // namespace panoptic
