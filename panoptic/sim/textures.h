// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Textures as the renderer samples them, and the step from light to pixel values.
#pragma once

#include <array>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"

namespace panoptic {

// sRGB to linear light, 0..1.
Vec3f linear_from_srgb(const Rgb& color);

// Light (1 = a white wall well lit) to sRGB, bright light compressed as film does.
Rgb tone_mapped(const Vec3f& light);

// A texture with its halved copies down to one pixel, so that far patterns average instead of flickering. Repeats.
class Texture {
 public:
  explicit Texture(const Image<Rgb>& image);

  // Linear light at (u, v), v upwards as in OBJ files; bilinear in the copy whose texels are as large as `footprint` (in texels
  // of the original) or a little smaller. REQUIRES |u|, |v| < 10^9.
  Vec3f sample(const Eigen::Vector2f& uv, float footprint) const;

  int width() const { return levels_.front().width(); }
  int height() const { return levels_.front().height(); }
  const Vec3f& mean() const { return mean_; }

 private:
  std::vector<Image<Rgb>> levels_;
  Vec3f mean_ = Vec3f::Ones();
};

}  // namespace panoptic
