// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Two balls, said to be chairs, on a table top, with labels that waver as those of networks do.
#pragma once

#include "panoptic/segmentation.h"
#include "tests/fusion/scenes.h"

namespace panoptic::test {

// The view from `angle` on an orbit around them.
inline Frame two_balls(double angle, std::int64_t index) {
  const Surface scene = nearest_of({sphere({0, 0, 0}, 0.4), sphere({0.7, 0.3, 0}, 0.25), plane(Vec3d::UnitY(), 0.5)});
  return render(scene, small_camera(), look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), index);
}

// `wrong` of 256 pixels have any label.
inline Segmentation wavering(const Frame& frame, std::uint32_t wrong) {
  const ClassId chair{3};
  Segmentation s{Image<std::uint16_t>(frame.color.width(), frame.color.height()),
                 {{chair, 0.9F, {{chair, 0.7F}, {ClassId{1}, 0.3F}}}, {ClassId{2}, 1, {}}, {chair, 0.8F, {}}}};
  std::uint32_t state = static_cast<std::uint32_t>(frame.index) * 747796405U + 1;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      const int segment = p.y() > 0.499 ? 2 : p.x() > 0.45 ? 3 : 1;
      state = state * 1664525U + 1013904223U;
      s.segment_at(u, v) = static_cast<std::uint16_t>(state >> 24 < wrong ? state >> 16 & 3 : segment);
    }
  }
  return s;
}

}  // namespace panoptic::test
