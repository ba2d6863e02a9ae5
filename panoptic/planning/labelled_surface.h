// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of a map in its z-up frame, sorted by what it belongs to.
#pragma once

#include <functional>
#include <map>
#include <string_view>
#include <vector>

#include "panoptic/base/polygon.h"
#include "panoptic/map.h"
#include "panoptic/planning/surface_samples.h"

namespace panoptic {

struct LabelledPoint {
  Vec3d at = Vec3d::Zero();
  Vec3d normal = Vec3d::UnitZ();
  double area_m2 = 0;  // the surface that it stands for
};

struct LabelledSurface {
  std::map<PanopticId, std::vector<LabelledPoint>> of_object;  // objects alone
  std::map<PanopticId, ClassId> class_of;                      // likewise
  std::vector<LabelledPoint> wall;                             // of the class "wall"
  std::vector<LabelledPoint> floor;
  double voxel_m = 0;
};

// Whether a point of the z-up frame was seen to be empty.
using SeenEmpty = std::function<bool(const Vec3d&)>;

// REQUIRES the samples of this map. Throws Error if there are none.
LabelledSurface labelled_surface(const PanopticMap& map, const SurfaceByBlock& samples, const Pose& grid_from_world);

// Whether a class is one of those that people sit on, lie on, or go through.
bool is_seat_class(std::string_view name);
bool is_lying_class(std::string_view name);
bool is_door_class(std::string_view name);

}  // namespace panoptic
