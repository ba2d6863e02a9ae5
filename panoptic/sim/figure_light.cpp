// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/figure_light.h"

#include <algorithm>

namespace panoptic {
namespace {

constexpr float kScattered = 0.5F;  // as furniture has it with nothing near
constexpr float kFromAbove = 0.2F;  // more of it comes from the ceiling than from the floor
constexpr float kLampSize_m = 0.25F;

}  // namespace

FigureLight::FigureLight(const Figure& figure, const Scene& scene, const RayTracer& tracer) {
  const Eigen::AlignedBox3d box = box_of(figure);
  if (box.isEmpty()) return;
  const Vec3f middle = box.center().cast<float>();
  for (const Lamp& lamp : scene.lamps) {
    const Vec3f to_lamp = lamp.position - middle;
    const float reach_m = to_lamp.norm() - kLampSize_m;
    if (reach_m <= 0 || tracer.trace(middle, unit(to_lamp), reach_m).triangle == kNoTriangle) lamps_.push_back(lamp);
  }
}

Vec3f FigureLight::at(const Vec3f& point, const Vec3f& normal) const {
  Vec3f light = Vec3f::Constant(kScattered * (1 + kFromAbove * normal.z()));
  for (const Lamp& lamp : lamps_) {
    const Vec3f to_lamp = lamp.position - point;
    const float distance_m = to_lamp.norm();
    const float cosine = std::max(0.0F, unit(to_lamp).dot(normal));
    light += cosine / std::max(distance_m * distance_m, kLampSize_m) * lamp.radiance;
  }
  return light;
}

Vec3f normal_at(const Limb& limb, const Vec3f& point) {
  const Vec3f axis = limb.to - limb.from;
  const float axis2 = axis.squaredNorm();
  const float along = axis2 > 0 ? std::clamp((point - limb.from).dot(axis) / axis2, 0.0F, 1.0F) : 0.0F;
  return unit(point - limb.from - along * axis);
}

}  // namespace panoptic
