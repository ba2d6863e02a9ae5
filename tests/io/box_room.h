// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A recording that is known to the last number: a room of 5 x 4 x 2.5 m with a box in it, seen along a way through it.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/source.h"

namespace panoptic::test {

struct BoxRoom : Dataset {
  explicit BoxRoom(std::vector<Pose> where) : way(std::move(where)), told(way) {}

  std::vector<Pose> way;                          // where the camera was
  std::vector<Pose> told;                         // what the recording says of it
  Camera camera{160, 120, 140, 140, 79.5, 59.5};  // told as well
  double depth_factor = 1;                        // told depth = factor * depth
  std::function<void(Image<float>&)> spoil = [](Image<float>&) {};
  RecordingNotes told_notes;

  std::string description() const override { return "a room"; }
  std::size_t size() const override { return way.size(); }
  ReadResult read(std::size_t position) const override;
  std::optional<Pose> pose(std::size_t position) const override { return told[position]; }
  RecordingNotes notes() const override { return told_notes; }
};

// Looks around while it walks; told is the truth.
BoxRoom walk_through_a_room(int frames = 60);
// Stands at one place and turns.
BoxRoom turn_in_a_room(int frames = 60);

}  // namespace panoptic::test
