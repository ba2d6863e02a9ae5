// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The votes of frames in voxels where the regularizer wrote another label. The map has one label per voxel: without these the
// next run would take what the last one wrote for an observation, and labels would creep over their neighbours run by run.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/map/voxel_label.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

// A voxel that holds another label than frames voted for.
struct OverruledVote {
  std::uint16_t voxel;  // within the block
  VoxelLabel voted;
  VoxelLabel written;
};

// The vote of the frames for a voxel that holds `now`, those frames included that came after the label was written. By Eq.
// 9-11, weight that they took off the written label was a vote for another one: the one that the voxel holds, else the one
// voted for before. Once votes have reached map.max_weight all of them fade; that is taken for votes against the label, which
// are few among so many.
VoxelLabel voted_since(const OverruledVote& vote, VoxelLabel now);

// Memory grows with the voxels whose label was overruled, a few percent of those near a surface.
class FrameVotes {
 public:
  FrameVotes() = default;
  // Restores what all() returned. REQUIRES each block's votes in the order of the voxels.
  explicit FrameVotes(std::vector<std::vector<OverruledVote>> votes) : votes_(std::move(votes)) {}
  // Votes by slot; blocks without votes may be missing at the end.
  const std::vector<std::vector<OverruledVote>>& all() const { return votes_; }

  // The votes of a block, in the order of its voxels.
  std::span<const OverruledVote> of(Slot slot) const {
    return slot < votes_.size() ? std::span<const OverruledVote>(votes_[slot]) : std::span<const OverruledVote>();
  }
  // The frames' vote for a voxel of that block, `held` being what it holds now.
  VoxelLabel voted(Slot slot, std::uint16_t voxel, VoxelLabel held) const;
  // Keeps a vote, or forgets the voxel's if what is written is what was voted for.
  void record(Slot slot, const OverruledVote& vote);
  // Renames labels (`new_label`, by label). Call it before the voxels' labels are renamed. Where the vote and the written label
  // become the same, the voxel gets the frames' weight, and the vote is forgotten.
  void rename(const std::vector<std::uint16_t>& new_label, VoxelMap& map);
  // Gives a voxel a label that something other than frames and the regularizer decided on. It takes the place and the weight of
  // the frames' vote, which is forgotten.
  void decide(Slot slot, std::uint16_t voxel, std::uint16_t label, VoxelBlock& block);
  // Forgets the votes for voxels that are no longer stored: a bit per voxel of the brick.
  void forget(Slot slot, int brick, std::uint64_t voxels);
  // Adds the labels that are voted for to those in use, by label.
  void add_in_use(std::vector<bool>& in_use) const;
  // Forgets votes for labels that are not in use, by label: their number may come to mean another object.
  void forget_unused(const std::vector<bool>& in_use);

 private:
  const OverruledVote* find(Slot slot, std::uint16_t voxel) const;

  std::vector<std::vector<OverruledVote>> votes_;  // by slot
};

// The regularizer's memory from run to run (crf/regularizer.h).
struct RegularizerState {
  std::vector<std::vector<OverruledVote>> votes;  // by slot, in the order of the voxels
  std::vector<std::uint64_t> handled;             // by slot: the epoch up to which the block's changes are regularized
};

}  // namespace panoptic
