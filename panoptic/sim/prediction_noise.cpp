// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/prediction_noise.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numeric>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/sim/displacement_field.h"
#include "panoptic/sim/prediction_stuff.h"
#include "panoptic/sim/prediction_things.h"
#include "panoptic/sim/random.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kShufflePurpose = 0x5348;

// Networks number what they find anew in every frame.
void shuffle_segments(Random random, Segmentation& segmentation) {
  std::vector<std::size_t> order(segmentation.segments.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  random.shuffle(order);
  std::vector<Segment> shuffled;
  std::vector<std::uint16_t> value_of(order.size() + 1, 0);
  for (const std::size_t old : order) {
    shuffled.push_back(std::move(segmentation.segments[old]));
    value_of[old + 1] = static_cast<std::uint16_t>(shuffled.size());
  }
  segmentation.segments = std::move(shuffled);
  for (std::size_t i = 0; i < segmentation.segment_at.size(); ++i) {
    segmentation.segment_at[i] = value_of[segmentation.segment_at[i]];
  }
}

PredictionNoise good() {
  PredictionNoise n;
  n.missed = 0.05F;
  n.small_px = 300;
  n.far_m = 8;
  n.truncated = 0.1F;
  n.merged = 0.05F;
  n.split = 0.03F;
  n.hallucinated = 0.01F;
  n.boundary_px = 1.5F;
  n.boundary_share = 0.01F;
  n.confused = 0.06F;
  n.score_mean = 0.85F;
  n.stuff_lost = 0.03F;
  n.stuff_swapped = 0.003F;
  n.things_as_stuff = 0.05F;
  return n;
}

PredictionNoise maskrcnn() {
  PredictionNoise n;
  n.missed = 0.22F;
  n.small_px = 1200;
  n.far_m = 6;
  n.truncated = 0.15F;
  n.merged = 0.15F;
  n.split = 0.08F;
  n.hallucinated = 0.04F;
  n.boundary_px = 2.5F;
  n.boundary_share = 0.045F;
  n.confused = 0.25F;
  n.score_mean = 0.55F;
  n.stuff_lost = 0.1F;
  n.stuff_swapped = 0.01F;
  n.things_as_stuff = 0.15F;
  return n;
}

PredictionNoise poor() {
  PredictionNoise n;
  n.missed = 0.3F;
  n.small_px = 2000;
  n.far_m = 4;
  n.truncated = 0.3F;
  n.merged = 0.3F;
  n.split = 0.15F;
  n.hallucinated = 0.08F;
  n.boundary_px = 4;
  n.boundary_share = 0.05F;
  n.confused = 0.35F;
  n.score_mean = 0.35F;
  n.stuff_lost = 0.2F;
  n.stuff_swapped = 0.04F;
  n.things_as_stuff = 0.3F;
  return n;
}

}  // namespace

Fields fields(PredictionNoise& n) {
  const Allowed share = in_range(0, 1);
  const Allowed pixels = in_range(0, 1e6);
  return {
      {"missed", &n.missed, "chance that a thing is not found although it is near, large and whole", share},
      {"small_px", &n.small_px, "of things with a mask of this many pixels half are missed besides", pixels},
      {"far_m", &n.far_m, "of things at this distance half are missed besides; 0: distance does not matter", in_range(0, 100)},
      {"truncated", &n.truncated, "chance that a thing is not found besides, because the image cuts it off", share},
      {"merged", &n.merged, "chance that two touching things of one class are given as one", share},
      {"split", &n.split, "chance that a thing is given as two parts", share},
      {"hallucinated", &n.hallucinated, "chance that something is found in a place, 0.6 m wide, where there is nothing", share},
      {"boundary_px", &n.boundary_px, "standard deviation of the displacement of boundaries", in_range(0, 50)},
      {"boundary_share", &n.boundary_share, "the same as a share of the thing's size, added", in_range(0, 0.5)},
      {"confused", &n.confused, "chance of a wrong class", share},
      {"score_mean", &n.score_mean, "share of correct findings that scores are made for; 1: every score is 1", in_range(0.01, 1)},
      {"score_certainty", &n.score_certainty, "the smaller, the nearer scores are to 0 and 1", in_range(0.1, 1000)},
      {"stuff_lost", &n.stuff_lost, "share of wall and floor that is given as unknown", share},
      {"stuff_swapped", &n.stuff_swapped, "share of wall that is given as floor and of floor that is given as wall", share},
      {"things_as_stuff", &n.things_as_stuff, "share of things and void that the semantic network takes for wall or floor",
       share},
      {"patch_m", &n.patch_m, "size of the patches of wrong stuff", in_range(0.01, 100)},
      {"object_share", &n.object_share, "share of chance that stays with a thing or place in every frame", share},
      {"view_share", &n.view_share, "share of chance that stays with the place of the camera", share},
      {"view_m", &n.view_m, "how far the camera moves until the view is another", in_range(0.01, 100)},
  };
}

const std::vector<std::string>& prediction_noise_presets() {
  static const std::vector<std::string> kNames = {"oracle", "good", "maskrcnn", "poor"};
  return kNames;
}

PredictionNoise prediction_noise_preset(const std::string& name) {
  if (name == "oracle") return {};
  if (name == "good") return good();
  if (name == "maskrcnn") return maskrcnn();
  if (name == "poor") return poor();
  throw Error(
      fmt::format("there is no prediction noise '{}'; choose one of {}", name, fmt::join(prediction_noise_presets(), ", ")));
}

// The presets' quality is that of networks whose outputs are joined so.
constexpr SegmentationOptions kAsInThePaper{.keep_whole_classes = false, .smaller_in_front = false};

Segmentation predict_with_noise(const PredictionNoise& noise, std::uint64_t seed, const SimulatedFrame& frame,
                                const LabelSet& labels) {
  const Observation observation{noise, seed, frame, labels};
  const DisplacementField field(seed, frame.frame.index, frame.rendering.depth.width(), frame.rendering.depth.height());
  Segmentation segmentation = fuse(noisy_semantic(observation, field), noisy_things(observation, field), labels, kAsInThePaper);
  shuffle_segments(Random(seed, kShufflePurpose, static_cast<std::uint64_t>(frame.frame.index)), segmentation);
  return segmentation;
}

}  // namespace panoptic
