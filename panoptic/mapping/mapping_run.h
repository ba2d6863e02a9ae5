// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A whole run over a recording, offline (frame after frame) or online (as from a camera).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "panoptic/mapper.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/publisher_loop.h"
#include "panoptic/mapping/run_tracker.h"
#include "panoptic/online.h"
#include "panoptic/pose_update.h"
#include "panoptic/predictor.h"
#include "panoptic/source.h"
#include "panoptic/tracked_run.h"

namespace panoptic {

inline constexpr const char* kOutOfMemory = "out of memory";  // a failure

struct MappingRun {
  const Dataset& dataset;
  FrameRange range;
  Predictor* predictor = nullptr;  // nullptr: geometry and colour alone
  Mapper& mapper;
  Checkpoints* checkpoints = nullptr;  // of the map file; nullptr: none is kept
  // Applied after their frames, in their order, and what is left before the end.
  std::span<const PoseUpdates> pose_updates = {};
  // Called with the number of positions done, before each; false: the run is to end there.
  std::function<bool(std::size_t done)> go_on = [](std::size_t) { return true; };
  // Gives the frames their poses, in place of the dataset's; nullptr: those of the dataset count.
  RunTracker* tracker = nullptr;
  // A folder for the masks of what moves: 8 bits, 255 = moves, <frame>.png for each frame that is used; empty: none. Not online.
  std::filesystem::path moving_masks;
  // The recording with its own poses, for the report of the tracker: `dataset` itself if its frames have them, another that was
  // opened beside it, or nullptr if there are none.
  const Dataset* given_poses = nullptr;
};

// A failure is not thrown: what was mapped before is worth keeping.
struct MappingResult {
  std::string stopped_by;                  // why the run ended early, a failure included; else empty
  std::string failure;                     // for a person; empty if nothing failed
  std::uint64_t without_prediction = 0;    // frames used that had none, although there was a predictor
  std::optional<std::int64_t> first_used;  // frame numbers, those before a resumed run included
  std::optional<std::int64_t> last_used;
  std::optional<OnlineReport> online;
  std::vector<Correction> corrections;  // in their order
  std::optional<TrackingReport> tracking;
};

// Frame after frame to the end of the range, then Mapper::finish. A resumed run goes on where its map file is. `publisher`: for
// those who look on, or nullptr.
MappingResult map_offline(const MappingRun& run, LoopPublisher* publisher = nullptr);

// The same with every stage on its own thread (online.h), frames coming at `speed` (Playback). Snapshots go to `latest`.
MappingResult map_online(const MappingRun& run, double speed, const OnlineOptions& options, LatestSnapshot& latest);

}  // namespace panoptic
