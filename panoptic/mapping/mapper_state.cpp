// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "panoptic/mapping/mapper_parts.h"

namespace panoptic {

MapperState mapper_state(const SavedMap& saved, const std::vector<FrameRecord>& frames, std::vector<FrameLog::Entry> log) {
  MapperState state{saved_state(saved), {}, std::move(log)};
  for (const FrameRecord& frame : frames) {
    if (frame.unused_because.empty()) {
      state.frames.count_used({frame.time_s, frame.world_from_camera.value_or(Pose::Identity()), frame.frame});
    } else {
      state.frames.count_skipped({frame.frame, frame.unused_because});
    }
  }
  return state;
}

MapperState MapperParts::state() const {
  return {{maintenance_.state(), regularizer_.state(), moving_tracks_.state(), presence_.state(), label_frames_, labelled_,
           up_sum_, last_frame_},
          frames_,
          log_.entries()};
}

void MapperParts::restore(PanopticMap map, MapperState state) {
  map_ = std::move(map);
  maintenance_.restore(std::move(state.maintenance));
  regularizer_.restore(std::move(state.regularizer));
  moving_tracks_ = MovingTracks(std::move(state.moving));
  presence_.restore(std::move(state.presence));
  frames_ = std::move(state.frames);
  log_ = FrameLog(std::move(state.log), log_.limit_bytes(), log_.copies());
  if (log_.size() == frames_.used()) retrace();
  label_frames_ = state.label_frames;
  labelled_ = state.labelled;
  up_sum_ = state.up_sum;
  last_frame_ = state.last_frame;
}

}  // namespace panoptic
