// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A labelled triangle mesh in world coordinates.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "panoptic/base/geometry.h"
#include "panoptic/data/labels.h"

namespace panoptic {

struct MeshVertex {
  Vec3f position = Vec3f::Zero();  // metres
  Vec3f normal = Vec3f::Zero();    // unit length, out of the surface towards free space
  Rgb color;
  ClassId class_id = ClassId::kUnknown;
  PanopticId panoptic_id = PanopticId::kUnknown;
};

// Vertices are shared by the triangles around them. Triangles run counter-clockwise seen from free space.
struct Mesh {
  std::vector<MeshVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace panoptic
