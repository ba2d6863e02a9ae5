// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The light that arrives at bodies that move. They neither throw shadows nor are shaded by their own limbs.
#pragma once

#include <vector>

#include "panoptic/sim/figures.h"
#include "panoptic/sim/ray_tracer.h"
#include "panoptic/sim/scene.h"

namespace panoptic {

// Lamps count where the middle of the body sees them, so that no ray is cast per pixel.
class FigureLight {
 public:
  FigureLight(const Figure& figure, const Scene& scene, const RayTracer& tracer);

  // Linear RGB at a point of the body's surface.
  Vec3f at(const Vec3f& point, const Vec3f& normal) const;

 private:
  std::vector<Lamp> lamps_;
};

// The outward normal of the limb at a point of its surface.
Vec3f normal_at(const Limb& limb, const Vec3f& point);

}  // namespace panoptic
