// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory, from frame to frame, of what moves and of what is gone: to save it, and to go on from there.
#pragma once

#include <bit>
#include <cstdint>
#include <map>
#include <vector>

#include "panoptic/free_space.h"
#include "panoptic/labels.h"
#include "panoptic/moving.h"

namespace panoptic {

struct MovingState {
  struct Followed {
    MovingTrack track;
    // In how many frames networks named it so; kUnknown: they looked, and did not see it.
    std::map<ClassId, std::uint64_t> named;
  };
  std::vector<Followed> followed;  // ascending by id
  std::uint32_t next_id = 1;
  std::uint64_t forgotten = 0;  // boxes of the oldest tracks, because there were too many
};

// The surface of an object that was looked through.
struct LostSurface {
  std::map<CellIndex, std::uint64_t> voxels;  // by the brick that they are in, a bit each
  std::int64_t frame = 0;                     // in which the last of it was
  std::uint64_t looked_at = 0;                // voxels when the object was last judged

  std::uint64_t count() const {
    std::uint64_t count = 0;
    for (const auto& [cell, bits] : voxels) count += static_cast<std::uint64_t>(std::popcount(bits));
    return count;
  }
};

// For how long something has been in a cell of free space, in frames that were used.
struct Stay {
  std::uint64_t since = 0;
  std::uint64_t last = 0;

  bool operator==(const Stay&) const = default;
};

struct PresenceState {
  std::map<PanopticId, LostSurface> lost;     // by object
  std::map<CellIndex, std::int64_t> came_up;  // cells that two views or more had seen empty before something came, by its frame
  std::map<CellIndex, Stay> stays;
};

}  // namespace panoptic
