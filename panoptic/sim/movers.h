// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// People and pets at home while it is filmed: where each is in every frame.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/sim/bodies.h"
#include "panoptic/sim/home.h"
#include "panoptic/sim/home_truth.h"

namespace panoptic {

enum class Activity : std::uint8_t { kStanding, kWalking, kSitting, kLying };

struct Mover {
  Body body;
  std::uint16_t instance = 0;
  std::vector<BodyPose> poses;       // one per frame
  std::vector<Activity> activities;  // likewise

  Figure figure_at(std::size_t frame) const { return {class_of(body.kind), instance, limbs_of(body, poses[frame])}; }
};

struct MoverOptions {
  std::uint64_t seed = 1;
  int people = 2;
  int cats = 0;
  int dogs = 0;
  std::uint16_t first_instance = 1;
};

// Walks, stands and sits them, at 30 frames a second. Nobody walks through furniture or closed doors, comes nearer than half
// a metre to the camera if there is any other way, or runs into another. `seats` are those that nobody moves.
std::vector<Mover> plan_movers(const Home& home, const std::vector<TrueSeat>& seats, const std::vector<Pose>& path,
                               const MoverOptions& options);

}  // namespace panoptic
