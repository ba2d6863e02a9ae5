// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A place that is visited again: a saved map, and a further recording that it goes on with.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/io/recording_list.h"
#include "panoptic/map_file.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/run_tracker.h"
#include "panoptic/source.h"

namespace panoptic {

// The recordings of a map file, in their order, and the next one, as a list: CheckpointSettings::earlier goes on from that map
// with it. Throws Error: no sound map, one that was not made by a run to its end, or of a part of its recording, or one whose
// camera was tracked where that of the next recording is not.
std::vector<ListedRecording> with_next_visit(const std::filesystem::path& map, ListedRecording next, bool is_tracked);

// The frames by which a tracker may recognise where it is in the map of the earlier visits.
struct RememberedPlaces {
  std::size_t frames = 0;
  std::size_t unreadable = 0;  // that could not be read again
  std::string reason;          // for which the first of them could not
};
// Hands such frames of the earlier visits to the tracker, with the poses that they have in the map. `records`: of all their
// frames; `dataset`: the list of all visits. Throws Error: the map has no log of its frames, or none of them can be read.
RememberedPlaces remember_visits(const Mapper& mapper, const std::vector<FrameRecord>& records, const Dataset& dataset,
                                 RunTracker& tracker);

}  // namespace panoptic
