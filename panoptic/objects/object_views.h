// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Remembers in which frames, and where in them, each object is seen best.
#pragma once

#include <cstdint>
#include <span>

#include "panoptic/objects.h"
#include "panoptic/segmentation.h"

namespace panoptic {

// A frame's segments after tracking, one entry per segment: the id that each was given (LabelTracker), and its pixels with a
// depth reading.
struct TrackedSegments {
  std::int64_t frame = 0;
  std::span<const LabelSlot> id;
  std::span<const std::uint32_t> visible_px;
};

// Offers every segment of an object that is visible to that object's best views. The colour image is looked through for boxes
// only if one of them is wanted, which soon gets rare.
void record_views(const Segmentation& segmentation, const TrackedSegments& tracked, ObjectRegistry& objects);

}  // namespace panoptic
