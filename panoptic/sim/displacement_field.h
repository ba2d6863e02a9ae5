// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How far the boundaries of predicted masks stray, at every pixel: smooth over the image, another field in every frame.
#pragma once

#include <cstdint>

#include "panoptic/base/image.h"

namespace panoptic {

// Adds to the image what a grid of values, one every `step` pixels, gives when interpolated between them. REQUIRES a grid that
// covers the image: (size - 1) / step + 2 values in each direction.
void add_interpolated(const Image<float>& grid, int step, Image<float>& image);

// Two components, each nearly standard normal with a correlation length of a few dozen pixels. Multiply by the deviation
// that is wanted.
class DisplacementField {
 public:
  DisplacementField(std::uint64_t seed, std::int64_t frame_index, int width, int height);

  float x(std::size_t pixel) const { return x_[pixel]; }
  float y(std::size_t pixel) const { return y_[pixel]; }

 private:
  Image<float> x_;
  Image<float> y_;
};

}  // namespace panoptic
