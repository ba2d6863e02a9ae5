// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Kidnappings: from one frame to the next the camera is carried to another place of its way, with nothing seen in between.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic {

struct Jump {
  std::size_t frame = 0;         // the first one at the new place
  Pose from = Pose::Identity();  // world_from_camera of the frame before
  Pose to = Pose::Identity();    // and of that frame
  bool is_seen = false;          // an earlier frame looked the same way from near there
};

struct JumpingPath {
  std::vector<Pose> poses;  // world_from_camera, one per frame
  std::vector<Jump> jumps;  // in order of time
};

constexpr std::size_t kFramesForAJump = 90;

// The result has as many frames as the path. The first third goes as the path does; then the camera is carried off every so
// often, and goes on along the path from where it is put down, up to 12 cm beside it and turned a little. Two of three times it
// is put down where it was before, if there is such a place that is elsewhere; else where it was not. Deterministic. Throws Error
// if so many jumps do not fit.
JumpingPath with_jumps(const std::vector<Pose>& path, int jumps, std::uint64_t seed);

inline constexpr const char* kJumpsFile = "jumps.json";
void write_jumps(const std::filesystem::path& path, const JumpingPath& truth, double rate_hz);

}  // namespace panoptic
