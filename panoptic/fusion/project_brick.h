// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Places of the voxels of a brick in a view. For use inside functions with PANOPTIC_CLONES only, into which it is inlined: plain
// arrays and nothing but ternaries in the loop, so that it vectorises by itself.
#pragma once

#include <cstdint>

#include "panoptic/fusion/integrate_kernels.h"

namespace panoptic::kernels {

// Where the voxels of a brick are in the camera, and which pixels they fall on: fills x, y, z, inverse_z and pixel of `s` from
// `first` on. Voxels outside the view have the pixel that stands for no reading.
template <typename Scratch>
[[gnu::always_inline]] inline void project_brick(const KernelFrame& frame, const BlockInCamera& place, int brick, int first,
                                                 Scratch& s) {
  const auto width = static_cast<float>(frame.width);
  const auto height = static_cast<float>(frame.height);
  const std::int32_t outside = frame.width * frame.height;
  const int bx = kBrickSide * (brick & 3);
  const int by = kBrickSide * (brick >> 2 & 3);
  const int bz = kBrickSide * (brick >> 4);
  for (int k = 0; k < kBrickVoxels; ++k) {
    const auto ix = static_cast<float>(bx + (k & 3));
    const auto iy = static_cast<float>(by + (k >> 2 & 3));
    const auto iz = static_cast<float>(bz + (k >> 4));
    const float x = place.origin[0] + iy * place.step_y[0] + iz * place.step_z[0] + ix * place.step_x[0];
    const float y = place.origin[1] + iy * place.step_y[1] + iz * place.step_z[1] + ix * place.step_x[1];
    const float z = place.origin[2] + iy * place.step_y[2] + iz * place.step_z[2] + ix * place.step_x[2];
    const float inverse = 1.0F / z;
    const float u = frame.fx * x * inverse + frame.cx + 0.5F;
    const float v = frame.fy * y * inverse + frame.cy + 0.5F;
    const bool inside = (z > 0) & (u >= 0) & (u < width) & (v >= 0) & (v < height);
    const auto ui = static_cast<std::int32_t>(inside ? u : 0.0F);
    const auto vi = static_cast<std::int32_t>(inside ? v : 0.0F);
    s.pixel[first + k] = inside ? vi * frame.width + ui : outside;
    s.x[first + k] = x;
    s.y[first + k] = y;
    s.z[first + k] = z;
    s.inverse_z[first + k] = inverse;
  }
}

}  // namespace panoptic::kernels
