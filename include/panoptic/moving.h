// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Things that moved before the camera: never a part of the map, but known by its tracks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"

namespace panoptic {

// One thing that moves, in one frame. Metres, world.
struct MovingThing {
  ClassId class_id = ClassId::kUnknown;  // of a mobile class; kUnknown: only its motion gave it away
  Vec3d min_m = Vec3d::Zero();
  Vec3d max_m = Vec3d::Zero();
  std::size_t pixels = 0;  // of the depth image

  bool operator==(const MovingThing&) const = default;
};

// The box of something that moves around the surface that one frame saw of it. Metres, world.
struct TrackedBox {
  std::int64_t frame = 0;
  double time_s = 0;
  Vec3d min_m = Vec3d::Zero();
  Vec3d max_m = Vec3d::Zero();

  bool operator==(const TrackedBox&) const = default;
};

// One thing that moved, for as long as it was followed. Ids count up from 1 and have nothing to do with those of objects.
struct MovingTrack {
  std::uint32_t id = 0;
  ClassId class_id = ClassId::kUnknown;  // kUnknown: no network ever named it
  std::vector<TrackedBox> boxes;         // in the order of the frames, one a frame at most, never empty

  bool operator==(const MovingTrack&) const = default;
};

}  // namespace panoptic
