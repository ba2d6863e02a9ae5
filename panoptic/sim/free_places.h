// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Free places for things that are moved.
#pragma once

#include <optional>
#include <vector>

#include "panoptic/sim/clearance_map.h"
#include "panoptic/sim/home.h"
#include "panoptic/sim/random.h"

namespace panoptic {

Eigen::AlignedBox3d box_of(const ThingBox& thing);

// Finds places in the room of a thing where it runs into nothing that ever stands there, keeps doors free, and the camera
// does not walk.
class FreePlaces {
 public:
  FreePlaces(const Home& home, const std::vector<Pose>& path);

  // A place apart from where the thing is; nothing if chance finds none. Half of them are against a wall.
  std::optional<ThingBox> find(const ThingBox& thing, Random& random) const;
  // Nothing else may be put there any more.
  void take(const ThingBox& place) { taken_.push_back(place); }

 private:
  bool is_free(const ThingBox& place, const ThingBox& old_place) const;

  const Home& home_;
  std::vector<Eigen::Vector2d> way_;
  std::vector<ThingBox> taken_;
  std::vector<FloorRect> doors_;  // with the floor before them
};

}  // namespace panoptic
