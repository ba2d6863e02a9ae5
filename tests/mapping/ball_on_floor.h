// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene of the mapper's tests: a ball, said to be a chair, on a floor. Its labels hold from every side.
#pragma once

#include "panoptic/segmentation.h"
#include "tests/fusion/scenes.h"

namespace panoptic::test {

inline Surface ball_on_floor() { return nearest_of({sphere({0, 0, 0}, 0.6), plane(Vec3d::UnitY(), 0.6)}); }

inline Segmentation segmented(const Frame& frame) {
  Segmentation s{Image<std::uint16_t>(frame.color.width(), frame.color.height()),
                 {{ClassId{3}, 0.9F, {{ClassId{3}, 1.0F}}}, {ClassId{2}, 1, {}}}};
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      s.segment_at(u, v) = p.y() > 0.599 ? 2 : 1;
    }
  }
  return s;
}

}  // namespace panoptic::test
