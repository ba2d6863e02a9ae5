// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// When the objects of a map were there, and what moved before the camera: for a look back in time (docs/moving.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/map_file.h"
#include "panoptic/moving.h"
#include "panoptic/query.h"

namespace panoptic {

// Times are seconds of the recording.
struct SceneHistory {
  double start_s = 0;  // the first and the last time that something is known of
  double end_s = 0;
  std::vector<ObjectSpan> spans;    // ascending by id
  std::vector<MovingTrack> tracks;  // ascending by id
  std::uint64_t forgotten_boxes = 0;

  // True where every time looks like the last one: nothing came, went or moved.
  bool is_still() const;
};

// The history that `panoptic run` left in objects.json and moving.json; without what an early version did not write. Throws
// Error as run_files.h does.
SceneHistory read_run_history(const std::filesystem::path& folder, const LabelSet& labels);

// The history that a map file keeps; `frames`: those of its file (load_frames). Throws Error: its notes are not of this map.
SceneHistory history_of(const SavedMap& saved, const std::vector<FrameRecord>& frames);

}  // namespace panoptic
