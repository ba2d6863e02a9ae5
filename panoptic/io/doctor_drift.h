// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Drift of the poses: surfaces that are seen again later lie elsewhere.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "panoptic/io/doctor.h"
#include "panoptic/io/doctor_geometry.h"

namespace panoptic {

// How far, along their normals, the surfaces of `from` have to move on the average to lie on those of `to`: point to plane (Chen
// and Medioni 1991), Cauchy's weights, from the declared poses on. Nothing if the two see too little of one surface. It sees
// errors up to 0.3 m.
std::optional<double> surfaces_apart_m(const ViewPair& pair);

// Distances of surfaces that are seen twice, metres.
struct Revisits {
  std::vector<float> later;  // kLater_s apart or more
  std::vector<float> soon;   // in neighbouring frames: what noise alone makes
};
inline constexpr double kLater_s = 5;

// Looks at so many frames, spread over the dataset, and at pairs of them whose poses say that they look at one place.
Revisits find_revisits(const Dataset& dataset, std::size_t frames);

Check check_drift(const Revisits& revisits);

}  // namespace panoptic
