// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The brightness of a colour image at several sizes.
#pragma once

#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"

namespace panoptic {

struct GreyLevel {
  Camera camera;      // the colour camera at this size
  Image<float> grey;  // 0 to 255
};

// A value of an image between its pixels, and how it changes to the right and downwards.
struct GreySample {
  float value = 0;
  float right = 0;
  float down = 0;
};

// Bilinear. REQUIRES 0 <= u <= width - 1 - epsilon, and v likewise: see is_inside.
inline GreySample sample(const Image<float>& image, float u, float v) {
  const int u0 = static_cast<int>(u);
  const int v0 = static_cast<int>(v);
  const float a = u - static_cast<float>(u0);
  const float b = v - static_cast<float>(v0);
  const float* top = image.row(v0) + u0;
  const float* bottom = image.row(v0 + 1) + u0;
  const float upper = top[0] + a * (top[1] - top[0]);
  const float lower = bottom[0] + a * (bottom[1] - bottom[0]);
  return {upper + b * (lower - upper), (1 - b) * (top[1] - top[0]) + b * (bottom[1] - bottom[0]), lower - upper};
}
inline bool is_inside(const Image<float>& image, float u, float v) {
  return u >= 0 && v >= 0 && u < static_cast<float>(image.width() - 1) && v < static_cast<float>(image.height() - 1);
}

inline constexpr int kGreyLevels = 3;

// The finest level first: at most 400 pixels wide, each further one half as large. Levels below 16 pixels are left out.
std::vector<GreyLevel> grey_pyramid(const ImageView<Rgb>& color, const Camera& camera);

}  // namespace panoptic
