// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/frame_votes.h"

#include <algorithm>

namespace panoptic {

VoxelLabel voted_since(const OverruledVote& vote, VoxelLabel now) {
  if (now.label != vote.written.label) return fused_label(vote.voted, now.label, vote.written.weight + now.weight);
  const float gained = now.weight - vote.written.weight;
  if (gained < 0) return fused_label(vote.voted, vote.voted.label, -gained);
  return gained > 0 ? fused_label(vote.voted, now.label, gained) : vote.voted;
}

void FrameVotes::record(Slot slot, const OverruledVote& vote) {
  if (slot >= votes_.size()) votes_.resize(std::size_t{slot} + 1);
  std::vector<OverruledVote>& votes = votes_[slot];
  const auto at = std::ranges::lower_bound(votes, vote.voxel, {}, &OverruledVote::voxel);
  const bool known = at != votes.end() && at->voxel == vote.voxel;
  if (vote.voted.label == vote.written.label) {
    if (known) votes.erase(at);
  } else if (known) {
    *at = vote;
  } else {
    votes.insert(at, vote);
  }
}

void FrameVotes::forget_unused(const std::vector<bool>& in_use) {
  for (std::vector<OverruledVote>& votes : votes_) {
    std::erase_if(votes, [&](const OverruledVote& vote) { return !in_use[vote.voted.label]; });
  }
}

}  // namespace panoptic
