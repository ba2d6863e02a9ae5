// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A field that says at every pixel how far the boundaries of predicted masks stray: smooth over the image, another one in every
// frame.
#pragma once

#include <cstdint>
#include <utility>

#include "panoptic/image.h"

namespace panoptic {

// Adds to the image a grid of values, one every `step` pixels, interpolated between them. REQUIRES a grid that covers the
// image: (size - 1) / step + 2 values in each direction.
void add_interpolated(const Image<float>& grid, int step, Image<float>& image);

// Two components, each nearly standard normal with a correlation length of a few dozen pixels.
class DisplacementField {
 public:
  DisplacementField(std::uint64_t seed, std::int64_t frame_index, int width, int height);

  // The pixel, within the image, that (u, v) shows instead of itself where boundaries stray by `deviation_px`.
  std::pair<int, int> source(int u, int v, float deviation_px) const {
    const float* x = x_.row(v);
    const float* y = y_.row(v);
    return {clamped(u + nearest(deviation_px * x[u]), x_.width()), clamped(v + nearest(deviation_px * y[u]), x_.height())};
  }
  // The same in another direction: two networks err apart.
  std::pair<int, int> other_source(int u, int v, float deviation_px) const {
    const float* x = x_.row(v);
    const float* y = y_.row(v);
    return {clamped(u + nearest(deviation_px * y[u]), x_.width()), clamped(v - nearest(deviation_px * x[u]), x_.height())};
  }

 private:
  // Displacements are far above -1000.
  static int nearest(float value) { return static_cast<int>(value + 1000.5F) - 1000; }
  static int clamped(int value, int size) { return value < 0 ? 0 : (value < size ? value : size - 1); }

  Image<float> x_;
  Image<float> y_;
};

}  // namespace panoptic
