// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Tells whether a surface is at a point, whether the point was seen to be empty, or whether nobody looked. The distance field
// alone knows only what is within the truncation of a surface. Beyond, the map's free space tells. A map without (of an older
// format, or made with map.free_space off) leaves it to a guess: a point was empty if a camera looked through it, that is, if the
// first surface on the ray from the camera through the point lies behind the point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/map_file.h"

namespace panoptic {

// A point nearer to a surface than kSurfaceBand_voxels is at the surface.
enum class Occupancy : std::uint8_t { kUnseen, kFree, kSurface };

// Describes a map as it is when this is made; the map must outlive it. const functions may be called from several threads.
class SeenSpace {
 public:
  // The guess, for maps without free space and for cells that are not free as a whole, as beside a surface. Cameras of frames
  // that were used; of many, this many spread evenly.
  static constexpr std::size_t kMostCameras = 256;
  // Half the angle of the cone around the optical axis that every depth camera sees: the file does not tell its intrinsics.
  static constexpr double kViewCone_deg = 20;

  // `reach_m`: how far the depth camera sees (depth.max_m).
  SeenSpace(const PanopticMap& map, const std::vector<FrameRecord>& frames, double reach_m);

  Occupancy at(const Vec3d& point_m) const;
  bool is_guessed() const { return free_space_.empty(); }

 private:
  bool seen_through(const Vec3d& point_m) const;
  bool passes(const Pose& world_from_camera, const Vec3d& point_m) const;

  const VoxelMap& map_;
  const FreeSpaceMap& free_space_;
  std::vector<Pose> cameras_;
  double reach_m_;
};

}  // namespace panoptic
