// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The corners of a model where light is computed, and the normals there.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/sim/scene.h"

namespace panoptic {

// Corners at the same position whose normals are alike share a place.
struct ModelPlaces {
  // Per triangle and corner, unit length, in the model's frame: the mean of the faces that meet there without a crease.
  std::vector<std::array<Vec3f, 3>> normals;
  std::vector<std::array<std::uint32_t, 3>> corner_at;  // per triangle and corner: its place
  std::vector<std::array<std::uint32_t, 2>> owners;     // per place: the triangle and corner that stand for it
};

// REQUIRES a model whose indices are valid (flatten checks them).
ModelPlaces places_of(const SceneModel& model);

}  // namespace panoptic
