// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// What frames voted for where the regularizer wrote something else. The map has one label per voxel: without this the next run
// would take what the last one wrote for an observation, and labels would creep over their neighbours run by run.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/fusion/integrate_kernels.h"
#include "panoptic/map/voxel_map.h"

namespace panoptic {

// A voxel that holds another label than frames voted for.
struct OverruledVote {
  std::uint16_t voxel;  // within the block
  VoxelLabel voted;
  VoxelLabel written;
};

// The vote of the frames, those included that changed what was written to what the voxel holds now: by Eq. 9-11 what they took
// off the written label was said for another one, for the one voted for before if the voxel does not tell. Once votes have come
// to map.max_weight all of them fade, which this takes for votes against the label: of so many, few.
VoxelLabel voted_since(const OverruledVote& vote, VoxelLabel now);

// Memory grows with the voxels whose label was overruled, a few percent of those near a surface.
class FrameVotes {
 public:
  FrameVotes() = default;
  // As all() of another one told. REQUIRES each block's votes in the order of the voxels.
  explicit FrameVotes(std::vector<std::vector<OverruledVote>> votes) : votes_(std::move(votes)) {}
  // By slot; blocks without votes may be missing at the end.
  const std::vector<std::vector<OverruledVote>>& all() const { return votes_; }

  // In the order of the voxels.
  std::span<const OverruledVote> of(Slot slot) const {
    return slot < votes_.size() ? std::span<const OverruledVote>(votes_[slot]) : std::span<const OverruledVote>();
  }
  // The frames' vote for a voxel of that block, `held` being what it holds now.
  VoxelLabel voted(Slot slot, std::uint16_t voxel, VoxelLabel held) const;
  // A voxel that is written as it was voted for is forgotten.
  void record(Slot slot, const OverruledVote& vote);
  // Labels become others (`new_label`, by label): call it before the voxels' are renamed. Where what frames voted for and what
  // was written are then the same, the voxel gets the frames' weight, and the vote is forgotten.
  void rename(const std::vector<std::uint16_t>& new_label, VoxelMap& map);
  // Something other than frames and the regularizer decided on the voxel's label, which takes the place of what frames voted for:
  // it is to have their weight, and their vote is forgotten.
  void decide(Slot slot, std::uint16_t voxel, std::uint16_t label, VoxelBlock& block);
  // Adds the labels that are voted for to those in use, by label.
  void add_in_use(std::vector<bool>& in_use) const;
  // Forgets votes for labels that are not in use, by label: their number may come to mean another object.
  void forget_unused(const std::vector<bool>& in_use);

 private:
  const OverruledVote* find(Slot slot, std::uint16_t voxel) const;

  std::vector<std::vector<OverruledVote>> votes_;  // by slot
};

}  // namespace panoptic
