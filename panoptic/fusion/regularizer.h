// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Regularizes the labels of the map with a fully connected CRF over panoptic labels (section III-G of the paper).
//
// What is written back. A voxel whose most probable label is the one it has keeps label and weight. Any other is treated as if
// it had been observed once more, by an observation of the most probable label with weight W^V (2q - 1) (Eq. 19 solved for W^L),
// which flips it by Eq. 11 - except that it never comes out surer of its new label than frames were of the old one. So no label
// weight ever grows beyond what frames gave it, and later frames can correct a label at least as easily as before.
//
// What it is made from. Not from what an earlier run wrote: where a label was overruled, the vote of the frames is kept apart
// (FrameVotes). However often it runs, a run gives what a single one would. A voxel that frames never voted on says nothing (all
// labels are as probable) and takes a label, without weight, only where its neighbours leave little doubt.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/fusion/frame_votes.h"
#include "panoptic/fusion/submap_graph.h"
#include "panoptic/map/voxel_map.h"

namespace panoptic {

// The paper's w1, w2 are 10 and 15 and it regularizes every voxel (configs/presets/paper.toml); on real recordings that
// loses small objects, see docs/decisions/0008-crf.md.
struct RegularizerOptions {
  bool enabled = true;
  int every_frames = 300;  // used frames between two runs: 10 s at 30 Hz
  float w1 = 4;
  float w2 = 4;
  float theta_alpha_m = 0.05F;
  float theta_beta = 20;
  int iterations = 5;
  int max_blocks = 25;
  float band_voxels = 1.5F;
  float highest_probability = 0.99F;
};
Fields fields(RegularizerOptions& options);

// A voxel that gets another label, with what it held when it was copied.
struct LabelChange {
  CoreVoxel before;
  VoxelLabel label;
};

struct SubmapChanges {
  std::vector<Slot> blocks;
  std::uint64_t epoch = 0;  // as in SubmapGraph
  std::vector<LabelChange> changes;
  PanopticId next_id = PanopticId::kUnknown;  // as in SubmapGraph
};

// What a regularizer remembers from run to run.
struct RegularizerState {
  std::vector<std::vector<OverruledVote>> votes;  // by slot, in the order of the voxels
  std::vector<std::uint64_t> handled;             // by slot: the epoch up to which the block's changes are regularized
};

// Three steps, so that the long one can run beside the mapping: choose and gather read the map, solve reads only its arguments,
// write_back changes the map. Each result depends on the map alone, not on the thread count.
class Regularizer {
 public:
  Regularizer(const RegularizerOptions& options, const VoxelMap& map);

  // Every submap with a block that changed since it was regularized, or with a neighbour of one. Returns how many voxels got
  // another label. Starts a new epoch and marks the blocks that it changed.
  std::size_t run(VoxelMap& map);

  std::vector<std::vector<Slot>> choose(const VoxelMap& map) const;
  SubmapGraph gather(const VoxelMap& map, const std::vector<Slot>& blocks) const;
  SubmapChanges solve(const SubmapGraph& submap, Ranges ranges = {}) const;
  // Leaves voxels alone that a frame has changed since they were copied. `map` must be in an epoch of its own (begin_epoch).
  std::size_t write_back(const SubmapChanges& changes, VoxelMap& map);
  // The overruled votes of frames, which whoever else changes labels must keep up to date.
  FrameVotes& votes() { return votes_; }
  const FrameVotes& votes() const { return votes_; }

  // By LabelSlot (kLabelSlots entries): those that its votes name, which must not be given to other objects.
  std::vector<bool> named_slots() const;

  // To save it, and to go on from there with the same map.
  RegularizerState state() const { return {votes_.all(), handled_}; }
  void restore(RegularizerState state) {
    votes_ = FrameVotes(std::move(state.votes));
    handled_ = std::move(state.handled);
  }

 private:
  SubmapChanges regularize(const VoxelMap& map, const std::vector<Slot>& blocks, MeanFieldScratch& scratch, Ranges ranges) const;
  SubmapChanges solve(const SubmapGraph& submap, MeanFieldScratch& scratch, Ranges ranges) const;

  RegularizerOptions options_;
  GatherSettings gather_;
  MeanFieldSettings mean_field_;
  FrameVotes votes_;
  std::vector<std::uint64_t> handled_;  // by slot: the epoch up to which the block's changes are regularized
};

}  // namespace panoptic
