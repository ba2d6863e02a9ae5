// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/boxes_in_view.h"

#include <cmath>

#include "panoptic/base/clones.h"

namespace panoptic {

namespace kernels {

// One axis of the image, in pixels.
struct ImageAxis {
  float focal, center, size;
};

// The pixels between two lines of sight, one more at each side for rounding.
struct PixelSpan {
  float from, to;
};

// The lines of sight are given by their places at the box's nearest and farthest depth.
[[gnu::always_inline]] static inline PixelSpan span_px(const ImageAxis& axis, float low, float high, float per_near,
                                                       float per_far) {
  return {low * (low < 0 ? per_near : per_far) * axis.focal + axis.center - 1,
          high * (high < 0 ? per_far : per_near) * axis.focal + axis.center + 2};
}

[[gnu::always_inline]] static inline std::int32_t first_px(const ImageAxis& axis, const PixelSpan& span) {
  return static_cast<std::int32_t>(span.from > 0 ? (span.from < axis.size ? span.from : axis.size) : 0.0F);
}

[[gnu::always_inline]] static inline std::int32_t last_px(const ImageAxis& axis, const PixelSpan& span) {
  return static_cast<std::int32_t>(span.to < axis.size - 1 ? (span.to > -1 ? span.to : -1.0F) : axis.size - 1);
}

[[gnu::always_inline]] static inline bool is_whole(const ImageAxis& axis, const PixelSpan& span) {
  return (span.from >= 0) & (span.to <= axis.size - 1);
}

PANOPTIC_CLONES
void find_boxes(const KernelFrame& frame_in, const BlockInCamera& grid_in, float half_steps, BoxesInView& boxes) {
  const KernelFrame frame = frame_in;
  const BlockInCamera grid = grid_in;
  BoxesInView* __restrict out = &boxes;
  constexpr float kMiddle = 0.5F * (kBrickSide - 1);  // from the first point of a box to its middle
  constexpr float kNearest_m = 1e-3F;                 // of boxes whose place in the view is worked out
  float half[3];
  for (int a = 0; a < 3; ++a) {
    half[a] = half_steps * (std::abs(grid.step_x[a]) + std::abs(grid.step_y[a]) + std::abs(grid.step_z[a]));
  }
  const ImageAxis along_u{frame.fx, frame.cx, static_cast<float>(frame.width)};
  const ImageAxis along_v{frame.fy, frame.cy, static_cast<float>(frame.height)};
  for (int n = 0; n < kBlockBricks; ++n) {
    const float ix = static_cast<float>(kBrickSide * (n & 3)) + kMiddle;
    const float iy = static_cast<float>(kBrickSide * (n >> 2 & 3)) + kMiddle;
    const float iz = static_cast<float>(kBrickSide * (n >> 4)) + kMiddle;
    const float x = grid.origin[0] + ix * grid.step_x[0] + iy * grid.step_y[0] + iz * grid.step_z[0];
    const float y = grid.origin[1] + ix * grid.step_x[1] + iy * grid.step_y[1] + iz * grid.step_z[1];
    const float z = grid.origin[2] + ix * grid.step_x[2] + iy * grid.step_y[2] + iz * grid.step_z[2];
    const float near = z - half[2];
    const float far = z + half[2];
    const bool clear = near > kNearest_m;
    const float per_near = 1.0F / (clear ? near : 1.0F);
    const float per_far = 1.0F / (clear ? far : 1.0F);
    const PixelSpan u = span_px(along_u, x - half[0], x + half[0], per_near, per_far);
    const PixelSpan v = span_px(along_v, y - half[1], y + half[1], per_near, per_far);
    out->nearest_m[n] = near;
    out->farthest_m[n] = far;
    out->first_u[n] = clear ? first_px(along_u, u) : 0;
    out->last_u[n] = clear ? last_px(along_u, u) : (far > 0 ? frame.width - 1 : -1);
    out->first_v[n] = clear ? first_px(along_v, v) : 0;
    out->last_v[n] = clear ? last_px(along_v, v) : frame.height - 1;
    const bool whole_u = is_whole(along_u, u);
    const bool whole_v = is_whole(along_v, v);
    out->whole[n] = (clear & whole_u & whole_v) ? 1 : 0;
  }
}

}  // namespace kernels

PixelBounds pixels_around(const KernelFrame& frame, const Vec3f& point, float half_m) {
  const float per_near = 1.0F / (point.z() - half_m);
  const float per_far = 1.0F / (point.z() + half_m);
  const auto width = static_cast<float>(frame.width);
  const auto height = static_cast<float>(frame.height);
  const kernels::PixelSpan u =
      kernels::span_px({frame.fx, frame.cx, width}, point.x() - half_m, point.x() + half_m, per_near, per_far);
  const kernels::PixelSpan v =
      kernels::span_px({frame.fy, frame.cy, height}, point.y() - half_m, point.y() + half_m, per_near, per_far);
  return {u.from, u.to, v.from, v.to};
}

}  // namespace panoptic
