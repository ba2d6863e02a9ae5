// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Panoptic labels for a recording that has no predictions: made up, but like real ones where it matters for time. Segments lie
// on the same places of the world in every frame, about ten to a frame, with ragged borders, and now and then one is missed.
#pragma once

#include <cstdint>

#include "panoptic/frame.h"
#include "panoptic/labels.h"
#include "panoptic/segmentation.h"

namespace panoptic {

struct SeededLabels {
  std::uint64_t seed = 1;
  double cell_m = 1.2;  // one made-up object or piece of wall per cube of this edge: about ten to a frame of a room
};

// A function of the frame and the settings alone, at the size of the colour image. Classes are those of `labels`, which must
// hold things and stuff.
Segmentation seeded_labels(const Frame& frame, const LabelSet& labels, const SeededLabels& settings);

}  // namespace panoptic
