// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The frames by which places are recognised, and how they stand to one another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "panoptic/camera_tracker.h"
#include "panoptic/tracking/features.h"
#include "panoptic/tracking/frame_alignment.h"
#include "panoptic/tracking/pose_graph.h"

namespace panoptic {

struct Keyframe {
  std::int64_t frame = 0;
  GreyReference grey;  // with its pose
  std::vector<Feature> features;
};

// A frame that is looked for among the keyframes.
struct Sighting {
  const Frame& frame;
  const std::vector<GreyLevel>& pyramid;
  const std::vector<Feature>& features;
  DepthLimits range;
};

// A keyframe that shows what a frame shows, and where the frame was taken as the keyframe sees it.
struct Recognition {
  std::size_t keyframe = 0;
  Pose keyframe_from_frame = Pose::Identity();
};

// The keyframes among the first `count` that show what the frame shows, at most `most`, those with the most features in common
// first. Features are compared, then brightness and depth of the whole view. The map is not asked, so that what is wrong with it
// does not matter.
std::vector<Recognition> recognise_among(const Sighting& sighting, const std::vector<Keyframe>& keyframes, std::size_t count,
                                         std::size_t most);

}  // namespace panoptic
