// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_support.h"

#include <algorithm>
#include <cmath>

namespace panoptic {

Votes votes_in(const VoxelMap& map, const SurfaceVoxels& surface, std::span<const std::uint32_t> voxels) {
  Votes votes;
  for (const std::uint32_t i : voxels) {
    const auto [slot, voxel] = surface.place_of(i);
    const VoxelBlock& block = map.block(slot);
    votes.all += block.vote_sum(voxel);
    if (static_cast<LabelSlot>(block.label(voxel)) == surface.label(i)) votes.for_label += block.label_weight(voxel);
  }
  votes.for_label = std::min(votes.for_label, votes.all);
  return votes;
}

double mean_score(const Object& object) {
  return object.observations == 0 ? 0 : std::min(1.0, object.score_sum / static_cast<double>(object.observations));
}

double support(const Object& object, const Votes& votes) { return mean_score(object) * votes.agreement(); }

double certainty(const Object& object, const Votes& votes) {
  constexpr double kHighestScore = 0.99;
  const double wrong = std::log1p(-std::min(kHighestScore, mean_score(object)));  // one detection, logarithm
  return -std::expm1(static_cast<double>(object.observations) * wrong * votes.agreement());
}

}  // namespace panoptic
