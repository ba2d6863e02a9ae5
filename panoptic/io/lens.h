// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The distortion of a lens, as OpenCV models it, and images without it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"

namespace panoptic {

// k1, k2, p1, p2, then k3, then k4, k5, k6 (plumb bob, rational polynomial); empty: a lens without distortion.
using Distortion = std::vector<double>;

// The coefficients, shortened by what does nothing. Throws Error, beginning with `source`, for a model of another name
// ("fisheye"), for other counts, and for numbers that are not finite.
Distortion to_distortion(const std::string& model, Distortion coefficients, const std::string& source);

// The place at which a point of the image plane (X / Z, Y / Z) appears; NaN beyond the radius at which the model turns back on
// itself.
Eigen::Vector2d distorted(const Eigen::Vector2d& point, const Distortion& distortion);

// Per pixel of the image without distortion: its place in the image with it, NaN where there is none.
using LensMap = Image<std::array<float, 2>>;
LensMap lens_map(const Camera& camera, const Distortion& distortion);

// The image that a camera without distortion would have taken. REQUIRES the size of the map. Depth is that of the nearest pixel,
// and missing where the lens did not look; colours are interpolated, and those of the border go on beyond it.
Image<float> undistorted(const Image<float>& depth, const LensMap& map);
Image<Rgb> undistorted(const Image<Rgb>& color, const LensMap& map);

}  // namespace panoptic
