// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Regularizes the labels of the map with a fully connected CRF over panoptic labels (section III-G of the paper).
//
// Output: a voxel whose most probable label is the one it has keeps label and weight. Any other is treated as if it had been
// observed once more, by an observation of the most probable label with weight W^V (2q - 1) (Eq. 19 solved for W^L), which
// flips it by Eq. 11 - except that it never comes out surer of its new label than frames were of the old one. So no label
// weight ever grows beyond what frames gave it, and later frames can correct a label at least as easily as before.
//
// Input: the votes of frames, never the labels that an earlier run wrote; where a label was overruled, the vote of the frames
// is kept apart (FrameVotes). However often it runs, a run gives what a single one would. A voxel that frames never voted on
// says nothing (all labels are as probable) and takes a label, without weight, only where its neighbours leave little doubt.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/crf/tile_graph.h"
#include "panoptic/map/frame_votes.h"
#include "panoptic/options.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

Fields fields(RegularizerOptions& options);

// A voxel that gets another label, with what it held when it was copied.
struct LabelChange {
  CoreVoxel before;
  VoxelLabel label;
};

struct TileChanges {
  std::vector<Slot> blocks;
  std::uint64_t epoch = 0;  // as in TileGraph
  std::vector<LabelChange> changes;
  PanopticId next_id = PanopticId::kUnknown;  // as in TileGraph
};

// Three steps, so that the long one can run beside the mapping: choose and gather read the map, solve reads only its arguments,
// write_back changes the map. Each result depends on the map alone, not on the thread count.
class Regularizer {
 public:
  Regularizer(const RegularizerOptions& options, const VoxelMap& map);

  // Regularizes every tile with a block that changed since it was last regularized, or with a neighbour of one. Returns how
  // many voxels got another label. Starts a new epoch and marks the blocks that it changed.
  std::size_t run(VoxelMap& map);

  std::vector<std::vector<Slot>> choose(const VoxelMap& map) const;
  TileGraph gather(const VoxelMap& map, const std::vector<Slot>& blocks) const;
  TileChanges solve(const TileGraph& tile, Ranges ranges = {}) const;
  // Writes the changes into the map, except where a frame has changed the voxel since it was copied. `map` must be in an epoch
  // of its own (begin_epoch).
  std::size_t write_back(const TileChanges& changes, VoxelMap& map);
  // The overruled votes of frames. All other code that changes labels must keep them up to date.
  FrameVotes& votes() { return votes_; }
  const FrameVotes& votes() const { return votes_; }

  // Flags by LabelSlot (kLabelSlots entries): the slots that its votes name, which must not be given to other objects.
  std::vector<bool> named_slots() const;

  // The state to save, from which to go on with the same map.
  RegularizerState state() const { return {votes_.all(), handled_}; }
  void restore(RegularizerState state) {
    votes_ = FrameVotes(std::move(state.votes));
    handled_ = std::move(state.handled);
  }

 private:
  TileChanges regularize(const VoxelMap& map, const std::vector<Slot>& blocks, MeanFieldScratch& scratch, Ranges ranges) const;
  TileChanges solve(const TileGraph& tile, MeanFieldScratch& scratch, Ranges ranges) const;

  RegularizerOptions options_;
  GatherSettings gather_;
  MeanFieldSettings mean_field_;
  FrameVotes votes_;
  std::vector<std::uint64_t> handled_;  // by slot: the epoch up to which the block's changes are regularized
};

}  // namespace panoptic
