// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Bodies that move: people and pets, made of a few round limbs.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/image.h"
#include "panoptic/labels.h"

namespace panoptic {

// All points within `radius_m` of a line; a ball where both ends are the same.
struct Limb {
  Vec3f from = Vec3f::Zero();
  Vec3f to = Vec3f::Zero();
  float radius_m = 0;
  Rgb color;
};

// A body in its pose at one moment, in the world.
struct Figure {
  ClassId class_id = ClassId::kUnknown;
  std::uint16_t instance = 0;
  std::vector<Limb> limbs;
};

// The box around all limbs; empty if there are none.
Eigen::AlignedBox3d box_of(const Figure& figure);

// The distance along the ray, in units of its direction's length, at which it enters the limb from outside; 0 if it never does.
double enter(const Limb& limb, const Vec3d& origin, const Vec3d& direction);

// The nearest limb that each pixel shows, if nothing else were there.
struct FigureLayer {
  struct Pixel {
    float depth_m = 0;  // planar; 0 = no limb
    std::uint16_t figure = 0;
    std::uint16_t limb = 0;
  };
  Image<Pixel> pixels;
};
FigureLayer draw_figures(const std::vector<Figure>& figures, const Camera& camera, const Pose& world_from_camera);

}  // namespace panoptic
