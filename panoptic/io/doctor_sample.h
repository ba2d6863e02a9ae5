// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The frames that the doctor looks at.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/io/calibration.h"
#include "panoptic/io/doctor_geometry.h"
#include "panoptic/source.h"

namespace panoptic {

// Facts about one frame of the sample.
struct FrameFacts {
  bool usable = false;
  std::string reason;
  bool rigid = false;
  double median_m = 0;  // 0: no reading
  Camera depth_camera;  // of every frame that could be read, usable or not
  Camera color_camera;
  Pose pose = Pose::Identity();
  // How many of its readings were looked at, and depths that at least one in a hundred of these has, with their number.
  std::size_t readings = 0;
  std::vector<std::pair<float, std::size_t>> common_m = {};
};

// A frame and the nearest later one that looks different, if there is one.
struct PairFacts {
  std::optional<ViewPair> pair;
  std::optional<double> step_m;  // to the next frame
};

// How far the camera moves from a position to the next, where both have a pose.
struct Step {
  std::size_t position = 0;
  double length_m = 0;
};

// Samples spread evenly over the dataset, decoded on several threads.
std::vector<FrameFacts> examine_frames(const Dataset& dataset, std::size_t samples);
std::vector<PairFacts> find_pairs(const Dataset& dataset, std::size_t samples);
// Without reading images; nothing if the dataset does not know its poses without them.
std::vector<Step> find_steps(const Dataset& dataset, std::size_t samples);

// The size that the principal point speaks of, if it is further than 20 % from the middle of the camera's own.
std::optional<ImageSize> other_size(const Camera& camera);

// The camera with intrinsics of another size scaled to the images. The poses are judged with it, so that one mistake is not
// reported as three.
Camera repaired(const Camera& camera);

double median(std::vector<float> values);  // 0 without values

}  // namespace panoptic
