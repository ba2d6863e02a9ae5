// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Boxes of a grid in the view of a camera: the pixels that they cover, and the depths that they lie between.
#pragma once

#include <cstdint>

#include "panoptic/fusion/integrate_kernels.h"
#include "panoptic/geometry.h"

namespace panoptic {

// Columns and rows of pixels; nothing if last < first.
struct PixelArea {
  std::int32_t first_u;
  std::int32_t last_u;
  std::int32_t first_v;
  std::int32_t last_v;

  bool is_empty() const { return last_u < first_u || last_v < first_v; }
};

// 64 boxes, numbered like the bricks of a block: depths in metres and pixels, a little more than needed, clipped to the image. A
// box that reaches behind the camera has all pixels, one that is behind it has none.
struct BoxesInView {
  alignas(64) float nearest_m[kBlockBricks];
  alignas(64) float farthest_m[kBlockBricks];
  alignas(64) std::int32_t first_u[kBlockBricks];
  alignas(64) std::int32_t last_u[kBlockBricks];
  alignas(64) std::int32_t first_v[kBlockBricks];
  alignas(64) std::int32_t last_v[kBlockBricks];
  alignas(64) std::int32_t whole[kBlockBricks];  // 1: all of the box is in front of the camera and in the image

  PixelArea pixels(int n) const { return {first_u[n], last_u[n], first_v[n], last_v[n]}; }
};

namespace kernels {

// `grid`: the centre of the first of 16^3 points and the steps between them, in the camera. Box n holds 4^3 of these points, and
// reaches `half_steps` from the middle of them along each axis of the grid.
void find_boxes(const KernelFrame& frame, const BlockInCamera& grid, float half_steps, BoxesInView& boxes);

}  // namespace kernels

// The pixels in which a box of the camera's axes lies, around a point that is farther away than `half_m`: a little more than
// needed, not clipped.
struct PixelBounds {
  float first_u, last_u, first_v, last_v;
};
PixelBounds pixels_around(const KernelFrame& frame, const Vec3f& point, float half_m);

}  // namespace panoptic
