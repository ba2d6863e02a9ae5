// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Follows what moves from frame to frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/map/presence_state.h"
#include "panoptic/moving.h"

namespace panoptic {

// A thing of one frame goes to the nearest track of its class that it can have come from at 2 m/s since that track's last box,
// at most 1 s ago; else it begins one. Not thread-safe; memory is bounded.
class MovingTracks {
 public:
  static constexpr std::size_t kMostBoxes = 200000;

  MovingTracks() = default;
  explicit MovingTracks(MovingState state) : state_(std::move(state)) {}
  const MovingState& state() const { return state_; }

  // Adds the things of a frame. `looked`: a network did, and knows nothing of those without a class. The last frame may come
  // again, with names for its things; one from before it begins tracks of its own.
  void add(std::span<const MovingThing> things, std::int64_t frame, double time_s, bool looked);
  // Where things with a class are thought to be at that time: where they were last seen, and as far around as they can have gone.
  // `looked`: at the last place alone, and without those of which networks that looked have mostly seen nothing.
  std::vector<MovingThing> expected(double time_s, bool looked) const;
  // Those that were seen in three frames or more, ascending by id.
  std::vector<MovingTrack> tracks() const;

 private:
  struct Match {
    std::size_t thing;
    std::size_t track;
    double distance_m;
  };

  std::vector<Match> matches(std::span<const MovingThing> things, double time_s) const;
  static void put(const MovingThing& thing, std::int64_t frame, double time_s, bool looked, MovingState::Followed& into);
  void forget_oldest();

  MovingState state_;
};

}  // namespace panoptic
