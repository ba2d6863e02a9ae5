// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Viewpoints that show a room well.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/mesh.h"

namespace panoptic {

struct View {
  Pose world_from_camera = Pose::Identity();
  Camera camera;
  Vec3d up = -Vec3d::UnitY();  // in the world; light comes from there
  std::string name;            // of the picture's file
};

// Three views for pictures of 1280x960. `front` looks from above at an angle, from where the most surface faces the camera.
// `side` looks from the opposite side or, where that shows little because the scan is one-sided, from less far round. `top`
// looks straight down, the longer side of the room across. All are fitted to the mesh, except that the odd bit far outside may
// be cut off, and leave room for a legend at the bottom. `up` need not have unit length; nonsense counts as -y.
std::vector<View> default_views(const Mesh& mesh, const Vec3d& up);

// Their names, in this order.
inline constexpr std::array kViewNames = {"front", "side", "top"};

// The rows at the bottom of a default view that the mesh does not reach.
constexpr int kLegendRows_px = 56;

}  // namespace panoptic
