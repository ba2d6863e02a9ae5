// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/frame_votes.h"

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

const OverruledVote* FrameVotes::find(Slot slot, std::uint16_t voxel) const {
  const std::span<const OverruledVote> votes = of(slot);
  if (votes.empty()) return nullptr;
  const auto at = std::ranges::lower_bound(votes, voxel, {}, &OverruledVote::voxel);
  return at != votes.end() && at->voxel == voxel ? &*at : nullptr;
}

VoxelLabel FrameVotes::voted(Slot slot, std::uint16_t voxel, VoxelLabel held) const {
  const OverruledVote* vote = find(slot, voxel);
  return vote == nullptr ? held : voted_since(*vote, held);
}

void FrameVotes::rename(const std::vector<std::uint16_t>& new_label, VoxelMap& map) {
  const auto stays = [&](std::uint16_t label) { return new_label[label] == label; };
  for (Slot slot = 0; slot < votes_.size(); ++slot) {
    std::erase_if(votes_[slot], [&](OverruledVote& vote) {
      VoxelBlock& block = map.block(slot);
      const VoxelLabel held{block.label(vote.voxel), block.label_weight(vote.voxel)};
      if (stays(held.label) && stays(vote.voted.label) && stays(vote.written.label)) return false;
      vote.voted = voted_since(vote, held);  // while labels mean what they did when frames came
      vote.voted.label = new_label[vote.voted.label];
      vote.written = {new_label[held.label], held.weight};
      const bool agree = vote.voted.label == vote.written.label;
      if (agree) block.set_label_weight(vote.voxel, std::min(vote.voted.weight, block.vote_sum(vote.voxel)));
      map.mark_changed(slot);
      return agree;
    });
  }
}

void FrameVotes::decide(Slot slot, std::uint16_t voxel, std::uint16_t label, VoxelBlock& block) {
  if (const OverruledVote* vote = find(slot, voxel)) {
    const VoxelLabel voted = voted_since(*vote, {block.label(voxel), block.label_weight(voxel)});
    block.set_label_weight(voxel, std::min(voted.weight, block.vote_sum(voxel)));
    votes_[slot].erase(votes_[slot].begin() + (vote - votes_[slot].data()));
  }
  block.set_label(voxel, label);
}

void FrameVotes::forget(Slot slot, int brick, std::uint64_t voxels) {
  if (slot >= votes_.size()) return;
  std::erase_if(votes_[slot], [&](const OverruledVote& vote) {
    return brick_of(vote.voxel) == brick && (voxels >> voxel_in_brick(vote.voxel) & 1) != 0;
  });
}

void FrameVotes::add_in_use(std::vector<bool>& in_use) const {
  for (const std::vector<OverruledVote>& votes : votes_) {
    for (const OverruledVote& vote : votes) in_use[vote.voted.label] = true;
  }
}

void FrameVotes::forget_unused(const std::vector<bool>& in_use) {
  for (std::vector<OverruledVote>& votes : votes_) {
    std::erase_if(votes, [&](const OverruledVote& vote) { return !in_use[vote.voted.label]; });
  }
}

}  // namespace panoptic
