// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A recording in place of a camera.
#pragma once

#include <cstddef>
#include <functional>

#include "panoptic/online.h"
#include "panoptic/source.h"

namespace panoptic {

struct Playback {
  static constexpr double kAsFastAsPossible = 0;

  FrameRange range;
  // 1: as fast as it was recorded, by the time stamps of the frames (recordings without any are taken to have 30 Hz); 2: twice as
  // fast. Frames are then handed over as a camera would, and dropped if the pipeline is behind. kAsFastAsPossible: whenever the
  // pipeline has room, and none is dropped.
  double speed = 1;
};

// Hands every position of the range to the pipeline, in order, until the end or until the pipeline is stopped; does not finish
// it. `look`, if given, is called with the number of positions done: before each, and at least every 50 ms while waiting for the
// time of the next; it may call pipeline.stop. `comes`, if given, is called for each position before it is handed over. While the
// map follows corrected poses, the clock of a recording that plays at a speed stands still. Frames are decoded ahead; if decoding
// cannot keep up, playback is slower than asked for.
void play(const Dataset& dataset, const Playback& playback, OnlinePipeline& pipeline,
          const std::function<void(std::size_t done)>& look = {},
          const std::function<void(const ReadResult& read, std::size_t position)>& comes = {});

}  // namespace panoptic
