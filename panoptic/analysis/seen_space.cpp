// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/seen_space.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "panoptic/map/cached_lookup.h"
#include "panoptic/map/voxel_grid.h"

namespace panoptic {
namespace {

constexpr double kNearest_m = 0.1;

// Distance in voxels at a point; not observed: nothing.
class DistanceAt {
 public:
  explicit DistanceAt(const VoxelMap& map) : lookup_(map), voxel_size_m_(map.voxel_size_m()) {}

  std::optional<float> operator()(const Vec3d& point_m) {
    const std::optional<VoxelPlace> place = place_of(point_m, voxel_size_m_);
    if (!place) return std::nullopt;
    const VoxelBlock* block = lookup_.find(place->block);
    if (block == nullptr || !(block->weight(place->offset) > 0)) return std::nullopt;
    return block->distance(place->offset) / static_cast<float>(voxel_size_m_);
  }

 private:
  CachedLookup lookup_;
  double voxel_size_m_;
};

}  // namespace

SeenSpace::SeenSpace(const PanopticMap& map, const std::vector<FrameRecord>& frames, double reach_m)
    : map_(map.voxels), free_space_(map.free_space), reach_m_(reach_m) {
  std::vector<const FrameRecord*> used;
  for (const FrameRecord& frame : frames) {
    if (frame.unused_because.empty() && frame.world_from_camera) used.push_back(&frame);
  }
  const std::size_t count = std::min(used.size(), kMostCameras);
  for (std::size_t i = 0; i < count; ++i) cameras_.push_back(*used[i * used.size() / count]->world_from_camera);
}

Occupancy SeenSpace::at(const Vec3d& point_m) const {
  const std::optional<float> distance = DistanceAt(map_)(point_m);
  if (!distance) return seen_through(point_m) ? Occupancy::kFree : Occupancy::kUnseen;
  if (*distance < -kSurfaceBand_voxels) return Occupancy::kUnseen;  // hidden behind a surface
  return *distance > kSurfaceBand_voxels ? Occupancy::kFree : Occupancy::kSurface;
}

bool SeenSpace::seen_through(const Vec3d& point_m) const {
  const std::optional<CellIndex> cell = free_space_.cell_around(point_m);
  if (cell && free_space_.at(*cell) == Space::kFree) return true;
  // A cell beside a surface is not free as a whole; the cameras' cones tell what of it was seen.
  return std::any_of(cameras_.begin(), cameras_.end(), [&](const Pose& camera) { return passes(camera, point_m); });
}

// True if the camera had the point in its cone and the first surface on the way through the point comes after it.
bool SeenSpace::passes(const Pose& world_from_camera, const Vec3d& point_m) const {
  static const double kLeastCosine = std::cos(kViewCone_deg * std::numbers::pi / 180);
  const Vec3d eye = world_from_camera.translation();
  const double distance_m = (point_m - eye).norm();
  if (!(distance_m > kNearest_m) || distance_m > reach_m_) return false;
  const Vec3d direction = (point_m - eye) / distance_m;
  if (direction.dot(world_from_camera.linear().col(2)) < kLeastCosine) return false;
  DistanceAt distance_at(map_);
  const double step_m = map_.voxel_size_m();
  for (double at_m = kNearest_m; at_m < reach_m_; at_m += step_m) {
    const std::optional<float> distance = distance_at(eye + at_m * direction);
    if (!distance || *distance > 1) continue;
    // Within a voxel of a surface, or inside one whose front nobody saw from here.
    return *distance >= -1 && at_m > distance_m + step_m;
  }
  return false;
}

}  // namespace panoptic
