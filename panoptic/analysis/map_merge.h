// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Two maps of one place, in the same frame of reference, as one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/analysis/object_matching.h"
#include "panoptic/map_pairs.h"

namespace panoptic {

struct MapMerge {
  MapWithFrames merged;  // without notes
  std::vector<ObjectMatch> matches;
  std::int64_t frame_shift = 0;  // was added to b's frame numbers
};

// Voxels: weights and votes are summed, up to the lower of both max_weight, which the merged map has; distance and colour are
// weighted means; of two labels the one with more weight stays and keeps the difference, as two observations of one voxel would
// (Eq. 9-11; a draw leaves a's, without weight). All of it in the same way whichever map comes first.
// Free space: what either saw; where they contradict each other, b is the later one and right. Where b looked through
// bricks of a in which it observed nothing itself, those are cleared first.
// Objects: match_objects tells which are one; evidence is summed. Objects of `a` keep their ids, those of `b` that have no
// counterpart get new ones, which count up. Objects that lose their last voxel are retired. The history of `a` stays, that of `b`
// is left out: its ids are other ones.
// Frames: those of `b` follow those of `a`. Where their numbers would not, a shift is added to them, in its objects too, so that
// each frame of the merged map has one number.
// Throws Error, naming the maps as `name_a` and `name_b`: not comparable (require_comparable), or out of ids or frame numbers.
MapMerge merge_maps(MapWithFrames a, const MapWithFrames& b, const std::string& name_a, const std::string& name_b);

// Merges a voxel block into another, voxel by voxel as above. `merged_slot`: by b's slots (kLabelSlots entries). `max_weight`
// may be infinite.
void merge_block(const BlockPlanes& from, const std::vector<std::uint16_t>& merged_slot, float max_weight, BlockPlanes& into);

}  // namespace panoptic
