// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// What a session remembers beside its map and objects, as notes of a map file (docs/map_format.md).
#pragma once

#include <vector>

#include "panoptic/map/map_file.h"
#include "panoptic/session/session.h"

namespace panoptic {

// All but the frame log, which follows from the frames.
MapNotes notes_of(const SessionState& state);

// The state that notes and frames tell. Throws Error if they are not of the map beside them.
SessionState session_state(const SavedMap& saved, const std::vector<FrameRecord>& frames);

}  // namespace panoptic
