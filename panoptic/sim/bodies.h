// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The limbs of people and pets in a pose.
#pragma once

#include <cstdint>

#include "panoptic/sim/figures.h"
#include "panoptic/sim/random.h"

namespace panoptic {

enum class BodyKind : std::uint8_t { kPerson, kCat, kDog };

// Proportions and colours.
struct Body {
  BodyKind kind = BodyKind::kPerson;
  double height_m = 1.7;  // of a person; of a pet up to its back
  Rgb skin{224, 172, 136};
  Rgb hair{60, 42, 30};  // and fur
  Rgb shirt{70, 100, 160};
  Rgb trousers{50, 52, 60};
  Rgb shoes{40, 36, 34};
};
Body random_body(BodyKind kind, Random& random);

// NYU40 has people; cats and dogs are numbered behind it.
constexpr ClassId kPersonClass{31};
constexpr ClassId kCatClass{41};
constexpr ClassId kDogClass{42};
ClassId class_of(BodyKind kind);

// How a body stands, walks, sits or lies at one moment.
struct BodyPose {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  // between the feet, on the floor
  double heading = 0;                            // of the eyes and toes
  double walked_m = 0;                           // the phase of the steps
  double stride = 0;                             // 0 = both feet below the body, 1 = full steps
  double down = 0;                               // 0 = upright, 1 = seated; a pet: lying
  Vec3d seat = Vec3d::Zero();                    // where a person sits then, on the surface
};

// The limbs in the world; no part is below the floor.
std::vector<Limb> limbs_of(const Body& body, const BodyPose& pose);

}  // namespace panoptic
