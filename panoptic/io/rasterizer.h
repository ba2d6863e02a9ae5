// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Draws shaded triangles into a picture: z-buffer, four samples per pixel, on all cores, the same picture on any number of them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"

namespace panoptic {

struct DrawnVertex {
  Vec3f at = Vec3f::Zero();  // u_px, v_px, 1 / z; 1 / z <= 0 where it is behind the camera
  float shade = 1;           // times color
  Rgb color;
  std::uint32_t label = 0;
};

struct Drawing {
  int width_px = 0;
  int height_px = 0;
  bool flat = false;  // one colour per triangle, that of its speaker (data/speaker.h), instead of a blend
  std::vector<DrawnVertex> vertices;
  const std::vector<std::array<std::uint32_t, 3>>* triangles = nullptr;
};

struct Picture {
  Image<Rgb> color;
  Image<std::uint32_t> label;   // of the triangle in front
  Image<std::uint8_t> covered;  // 1 where there is a triangle, 0 for background
};

// Triangles are drawn where they turn counter-clockwise on the screen; from behind they are not there, so that a room scanned
// from inside can be looked into through its walls. Left out too: triangles that reach behind the camera or more than 16,000 px
// beyond the picture. Creases, silhouettes and, if flat, borders between labels get a thin dark line.
Picture rasterize(const Drawing& drawing);

}  // namespace panoptic
