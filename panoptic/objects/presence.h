// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Tells which objects are gone, which came, and which were moved.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "panoptic/map.h"
#include "panoptic/map/frame_votes.h"
#include "panoptic/map/presence_state.h"

namespace panoptic {

// An object is gone if half of its surface and more was looked through (fusion/carving.h) and has no surface again, or lies where
// views see nothing, and no network has seen it since; then all that is left of it is cleared. It is listed if there was enough
// of it for a thing. An object came if more than half of its surface lies where there was free space, or an eighth that came up
// no later than it was first seen. It was moved if one of its class and about its size is gone. Not thread-safe.
class ObjectPresence {
 public:
  // Voxels of a brick are about to be cleared.
  void looks_through(Slot slot, int brick, std::uint64_t voxels, std::int64_t frame, const PanopticMap& map);
  void came_up(std::span<const CellIndex> cells, std::int64_t frame);
  // How many frames were used before this one, and how many of those were as long ago as something must stay, or may be missed.
  struct FramesBefore {
    std::uint64_t now = 0;
    std::uint64_t stay = 0;  // kStay_s and more before this frame
    std::uint64_t gap = 0;   // kLongestGap_s and more
  };
  static constexpr double kStay_s = 2;
  static constexpr double kLongestGap_s = 0.35;  // ten frames of a camera of 30 a second, and some jitter
  // Cells of free space that something is in, ascending. Returns those that it has been in for two seconds: it is furniture.
  std::vector<CellIndex> settled(std::span<const CellIndex> cells, const FramesBefore& before);

  struct Rules {
    std::uint64_t min_observations = 1;  // objects that were seen less often were never there
    bool is_last = false;                // judges those too of which little more was looked through since
  };
  // Between frames, and before objects without voxels are forgotten: puts down which are gone, and clears what is left of them.
  void find_gone(const Rules& rules, FrameVotes& votes, PanopticMap& map);
  // At the end: which came, and which of those are the ones that are gone. A frame has a time in seconds.
  using TimeOf = std::function<double(std::int64_t frame)>;
  void find_arrivals(const TimeOf& time_of, PanopticMap& map) const;

  const PresenceState& state() const { return state_; }
  void restore(PresenceState state) { state_ = std::move(state); }

 private:
  bool has_news(bool is_last) const;
  std::vector<bool> gone_labels(const PanopticMap& map);
  std::vector<bool> appeared(const TimeOf& time_of, const PanopticMap& map) const;
  std::map<PanopticId, LostSurface> still_lost(const PanopticMap& map) const;

  PresenceState state_;
};

}  // namespace panoptic
