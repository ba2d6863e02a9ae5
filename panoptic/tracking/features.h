// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Corners of an image that can be found again from elsewhere: Shi and Tomasi's corners, each with a binary descriptor in the
// manner of ORB (Rublee et al. 2011). Depth gives their size, so that no pyramid of scales is needed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "panoptic/tracking/depth_points.h"
#include "panoptic/tracking/grey_pyramid.h"

namespace panoptic {

using Descriptor = std::array<std::uint64_t, 4>;

struct Feature {
  Vec3f in_camera = Vec3f::Zero();  // of the depth camera, metres
  Descriptor descriptor{};
};

// The number of bits that differ.
int distance(const Descriptor& a, const Descriptor& b);

// At most 400 of a frame, the strongest corners first.
std::vector<Feature> find_features(const Frame& frame, const std::vector<GreyLevel>& pyramid, const DepthLimits& range);

// Points of two frames that look the same, each the best partner of the other and clearly better than the second best.
struct FeatureMatch {
  std::size_t a = 0;
  std::size_t b = 0;
};
std::vector<FeatureMatch> match(const std::vector<Feature>& a, const std::vector<Feature>& b);

}  // namespace panoptic
