// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Records what became of every position of a recording: for the map file of the run, if there is one, and for its report.
#pragma once

#include <cstdint>
#include <optional>

#include "panoptic/mapper.h"
#include "panoptic/mapping/checkpoint.h"

namespace panoptic {

// Not thread-safe. Frames that a resumed run used before count as if they had been used now.
class RunRecorder {
 public:
  // `checkpoints`: of the map file; nullptr: none is kept.
  explicit RunRecorder(Checkpoints* checkpoints = nullptr);

  // The next position of the recording: a frame that the mapper was given, or one that it never was (dropped, unreadable).
  // Returns the position in the map file, for `labelled`; 0 where none is kept.
  std::int64_t frame(const Frame& frame, bool labelled, const Outcome& outcome);
  void not_given(FrameRecord record);
  // The labels of a frame came later than its geometry; the pose is that which the map has of it by now.
  void labelled(const Frame& frame, const Pose& world_from_camera, std::int64_t position);
  // Between frames: begins a checkpoint if it is time.
  void save_if_due(Mapper& mapper);

  std::optional<std::int64_t> first_used() const { return first_used_; }  // frame numbers
  std::optional<std::int64_t> last_used() const { return last_used_; }

 private:
  void count(const FrameRecord& record);

  Checkpoints* checkpoints_;
  std::optional<std::int64_t> first_used_;
  std::optional<std::int64_t> last_used_;
};

}  // namespace panoptic
