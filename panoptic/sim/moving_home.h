// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A home, the camera's way through it, and all that happens meanwhile.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/io/dynamics.h"
#include "panoptic/sim/change_plan.h"
#include "panoptic/sim/home.h"
#include "panoptic/sim/movers.h"
#include "panoptic/sim/renderer.h"

namespace panoptic {

class Catalogue;

// Nothing moves; people and pets walk about; furniture is changed behind the camera's back; both.
enum class Dynamics : std::uint8_t { kStatic, kPeople, kChanges, kBusy };
const std::vector<std::string>& dynamics_names();
// Throws Error listing the names if there is none such.
Dynamics dynamics_of(const std::string& name);

struct MovingHomeOptions {
  HomeOptions home;
  int frames = 0;  // 0 = as many as the way takes at 30 Hz
  Dynamics dynamics = Dynamics::kStatic;
};

struct MovingHome {
  Home home;  // with every thing in each of its places
  std::vector<Pose> path;
  std::vector<Change> changes;      // in order of time
  std::vector<std::size_t> starts;  // the first frame of each presence but the first, ascending
  std::vector<Presence> presences;  // of the objects of the home
  std::vector<Mover> movers;

  std::size_t presence_at(std::size_t frame) const;
  std::vector<Figure> figures_at(std::size_t frame) const;
};

// With changes the camera walks its way twice: else nobody could see them.
MovingHome make_moving_home(const MovingHomeOptions& options, const Catalogue& catalogue, const Camera& camera);

// The home as it is at the end; without textures.
Home final_home(const MovingHome& world);

// The class set of the home's scene: that of scannet20, and people, cats and dogs if there are any.
LabelSet labels_of(const MovingHome& world);

// Looks at the world along the whole way.
DynamicsTruth dynamics_truth(const MovingHome& world, const Renderer& renderer, const Camera& camera,
                             const std::string& dynamics);

}  // namespace panoptic
