// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Furniture that is moved, taken away and brought while the camera is elsewhere, and doors that are shut behind it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "panoptic/io/dynamics.h"
#include "panoptic/sim/home.h"

namespace panoptic {

struct Change {
  EventKind kind = EventKind::kRemoved;
  std::size_t frame = 0;  // the first one in which it is so
  std::uint16_t instance = 0;
  std::optional<std::uint32_t> before;  // the object of the scene that is there until then
  std::optional<std::uint32_t> after;   // and from then on
};

// Plans changes by what the camera sees on its way: each happens while nothing of it is in view, and its places are shown
// before and afterwards. A thing in its new place is appended to the scene's objects, with the instance that it has in the old
// one. In order of time; none if there is no moment for any.
std::vector<Change> plan_changes(std::uint64_t seed, const std::vector<Pose>& path, const Camera& camera, Home& home);

}  // namespace panoptic
