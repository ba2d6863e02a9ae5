// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How much speaks for an object: what the networks said of it, and how far the votes of the frames agree. Rules beyond the paper
// may overrule what is weak, and leave alone what is sure.
#pragma once

#include <cstdint>
#include <span>

#include "panoptic/map.h"
#include "panoptic/objects/surface_voxels.h"

namespace panoptic {

// The weight of votes in some voxels: for the label that they hold, and of all that looked at them (Eq. 9-11, 18).
struct Votes {
  double for_label = 0;
  double all = 0;

  double agreement() const { return all > 0 ? for_label / all : 0; }  // 0 to 1
};

Votes votes_in(const VoxelMap& map, const SurfaceVoxels& surface, std::span<const std::uint32_t> voxels);

// The mean score of an object's detections; 0 without any.
double mean_score(const Object& object);

// The probability that a part of an object with these votes is a part of it: what its detections claim, times the share of the
// frames that saw it there.
double support(const Object& object, const Votes& votes);

// The probability that at least one detection of an object was right, if each was by its score, in the share of the frames that
// agree.
double certainty(const Object& object, const Votes& votes);

}  // namespace panoptic
