// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/tracking/keyframes.h"

#include <algorithm>

#include "panoptic/options.h"
#include "panoptic/parallel.h"
#include "panoptic/tracking/rigid_fit.h"

namespace panoptic {
namespace {

constexpr std::size_t kLeastInliers = 12;
constexpr double kLeastInlierShare = 0.25;  // of the matches
constexpr std::size_t kLeastCompared = 150;
constexpr double kLeastComparedShare = 0.25;  // of the keyframe's points
constexpr double kLeastCorrelation = 0.7;

// A map of nothing, for alignment by brightness alone.
const VoxelMap& nothing() {
  static const VoxelMap kNothing{MapOptions()};
  return kNothing;
}

struct Candidate {
  std::size_t keyframe = 0;
  RigidFit fit;
};

// Brightness and depth decide: a few features may look alike where the view as a whole does not.
std::optional<Recognition> confirmed(const Sighting& sighting, const Candidate& candidate, const Keyframe& keyframe) {
  GreyReference reference = keyframe.grey;
  reference.world_from_camera = Pose::Identity();
  const AlignmentTask task{sighting.frame, sighting.pyramid, nothing(), &reference, sighting.range};
  const Alignment alignment = align(task, candidate.fit.a_from_b);
  const bool is_seen = alignment.grey_points >= kLeastCompared && alignment.grey_share >= kLeastComparedShare;
  if (!is_seen || alignment.grey_correlation < kLeastCorrelation) return std::nullopt;
  return Recognition{candidate.keyframe, alignment.world_from_camera};
}

bool is_worth_a_look(const RigidFit& fit, std::size_t matches) {
  return fit.inliers >= kLeastInliers && static_cast<double>(fit.inliers) >= kLeastInlierShare * static_cast<double>(matches);
}

}  // namespace

std::vector<Recognition> recognise_among(const Sighting& sighting, const std::vector<Keyframe>& keyframes, std::size_t count,
                                         std::size_t most) {
  std::vector<Candidate> candidates(count);
  parallel_for(count, [&](std::size_t k) {
    const std::vector<FeatureMatch> matches = match(keyframes[k].features, sighting.features);
    if (matches.size() < kLeastInliers) return;
    const RigidFit fit = fit_rigid(keyframes[k].features, sighting.features, matches);
    if (is_worth_a_look(fit, matches.size())) candidates[k] = {k, fit};
  });
  std::erase_if(candidates, [](const Candidate& c) { return c.fit.inliers == 0; });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.fit.inliers > b.fit.inliers; });
  std::vector<Recognition> found;
  constexpr std::size_t kTries = 3;
  for (std::size_t i = 0; i < candidates.size() && i < kTries * most && found.size() < most; ++i) {
    if (auto recognition = confirmed(sighting, candidates[i], keyframes[candidates[i].keyframe])) found.push_back(*recognition);
  }
  return found;
}

}  // namespace panoptic
