// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A place that is visited again: a saved map, and a further recording that it goes on with.
#pragma once

#include <filesystem>
#include <vector>

#include "panoptic/io/recording_list.h"

namespace panoptic {

// The recordings of a map file, in their order, and the next one, as a list: CheckpointSettings::earlier goes on from that map
// with it. Throws Error: no sound map, one that was not made by a run to its end, or of a part of its recording.
std::vector<ListedRecording> with_next_visit(const std::filesystem::path& map, ListedRecording next);

}  // namespace panoptic
