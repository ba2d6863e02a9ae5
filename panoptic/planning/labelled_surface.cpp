// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/labelled_surface.h"

#include <algorithm>
#include <array>
#include <span>

#include "panoptic/error.h"

namespace panoptic {
namespace {

bool is_one_of(std::string_view name, std::span<const std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

bool is_seat_class(std::string_view name) {
  constexpr std::array<std::string_view, 9> kNames = {"chair", "armchair", "sofa", "couch",     "stool",
                                                      "bench", "ottoman",  "seat", "sofa chair"};
  return is_one_of(name, kNames);
}

bool is_lying_class(std::string_view name) {
  constexpr std::array<std::string_view, 4> kNames = {"bed", "sofa", "couch", "mattress"};
  return is_one_of(name, kNames);
}

bool is_door_class(std::string_view name) { return name == "door" || name == "doorframe"; }

LabelledSurface labelled_surface(const PanopticMap& map, const SurfaceByBlock& samples, const Pose& grid_from_world) {
  if (!is_finite(grid_from_world)) throw Error("the z-up frame of the map is not finite; give another direction for up");
  LabelledSurface result;
  result.voxel_m = double{map.voxels.voxel_size_m()};
  const double face_m2 = result.voxel_m * result.voxel_m;
  std::size_t points = 0;
  for (const auto& block : samples) {
    for (const SurfaceSample& sample : block) {
      ++points;
      // One sample per crossed edge of the voxel grid: as many of them per area as the normal's components add up to.
      const double edges = std::max(1.0, double{sample.normal.cwiseAbs().sum()});
      const LabelledPoint point{grid_from_world * sample.at_m.cast<double>(),
                                grid_from_world.linear() * sample.normal.cast<double>(), face_m2 / edges};
      const ClassId class_id = map.class_of(sample.label);
      const PanopticId id = map.objects.id_of(sample.label);
      if (map.labels.is_object(id)) {
        result.of_object[id].push_back(point);
        result.class_of[id] = class_id;
      }
      if (map.labels.name_of(class_id) == "wall") result.wall.push_back(point);
      if (is_floor_class(map.labels, class_id)) result.floor.push_back(point);
    }
  }
  if (points == 0) throw Error("the map has no surface; map a recording with depth first");
  return result;
}

}  // namespace panoptic
