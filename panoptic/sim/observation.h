// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One frame on its way through the prediction noise, and the chance that the effects draw from.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "panoptic/sim/prediction_noise.h"
#include "panoptic/sim/smooth_noise.h"

namespace panoptic {

// Errors of networks; each has chance of its own.
enum class Effect : std::uint64_t { kMissed = 0x4e31, kMerged, kSplit, kHallucinated, kConfused, kFavourite, kWhich, kScore };

struct Observation {
  const PredictionNoise& noise;
  std::uint64_t seed;
  const SimulatedFrame& frame;
  const LabelSet& labels;

  std::uint64_t frame_number() const { return static_cast<std::uint64_t>(frame.frame.index); }

  // A number in 0..1, uniform over all keys and frames. For one key it is partly the same in every frame, partly the same
  // while the camera stays near: a thing that is missed once is missed again.
  double chance(Effect effect, std::uint64_t key) const {
    const double by_object = static_cast<double>(noise.object_share);
    const double by_view = std::min(static_cast<double>(noise.view_share), 1 - by_object);
    const std::uint64_t stream = hash_bits(seed, static_cast<std::uint64_t>(effect), key);
    const Vec3d eye = frame.true_world_from_camera.translation() / static_cast<double>(noise.view_m);
    const double z = std::sqrt(by_object) * nearly_normal(mix_bits(stream)) + std::sqrt(by_view) * smooth_noise(stream, eye) +
                     std::sqrt(1 - by_object - by_view) * nearly_normal(hash_bits(stream, frame_number()));
    return share_below(z);
  }
  // A number in 0..1, uniform over all keys and the same in every frame.
  double fixed_chance(Effect effect, std::uint64_t key) const {
    return unit_interval(hash_bits(seed, static_cast<std::uint64_t>(effect), ~key));
  }
};

}  // namespace panoptic
