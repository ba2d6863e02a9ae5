// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The level part of a thing's surface, by its normals: the seat of a chair, the mattress of a bed.
#pragma once

#include <optional>
#include <vector>

#include "panoptic/planning/labelled_surface.h"

namespace panoptic {

struct HeightSpan {
  double low_m = 0;
  double high_m = 0;
};

struct LevelPatch {
  std::vector<Vec3d> points;
  Vec3d normal = Vec3d::UnitZ();  // the mean
  Vec3d center = Vec3d::Zero();   // the mean; z is the median height
  double area_m2 = 0;
};

// The largest connected part within the band whose normals are within 40 degrees of up, and parts level with it (within 5 cm: the
// cushions of a sofa). Nothing if that is less than `least_m2`.
std::optional<LevelPatch> level_patch(const std::vector<LabelledPoint>& points, const HeightSpan& band, double voxel_m,
                                      double least_m2);

}  // namespace panoptic
