// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A place that is visited again: a saved map, and a further recording that it goes on with.
#pragma once

#include <cstddef>
#include <filesystem>
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

// Hands frames of the earlier visits, by which it may recognise where it is, to the tracker, with the poses that they have in the
// map; returns how many. `records`: of all their frames; `dataset`: the list of all visits. Throws Error: the map has no log of
// all of them, or one of those cannot be read again.
std::size_t remember_visits(const Mapper& mapper, const std::vector<FrameRecord>& records, const Dataset& dataset,
                            RunTracker& tracker);

}  // namespace panoptic
