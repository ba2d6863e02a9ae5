// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// What a session remembers beside its map and objects, as notes of a map file (docs/map_format.md).
#pragma once

#include <string>
#include <vector>

#include "panoptic/map/map_file.h"
#include "panoptic/session/session.h"

namespace panoptic {

// Names of the texts that tell of the run.
namespace run_note {
inline constexpr const char* kRecording = "recording";
inline constexpr const char* kCalibration = "calibration";
inline constexpr const char* kFrames = "frames_range";
inline constexpr const char* kOptions = "options";
inline constexpr const char* kPositions = "positions";
inline constexpr const char* kComplete = "complete";
inline constexpr const char* kUp = "up";
inline constexpr const char* kProgram = "program";
inline constexpr const char* kOnline = "online";
}  // namespace run_note

// Empty if the map has no such text.
std::string note_or_empty(const SavedMap& saved, const std::string& name);

// All but the frame log, which follows from the frames.
MapNotes notes_of(const SessionState& state);

// The state that notes and frames tell. Throws Error if they are not of the map beside them.
SessionState session_state(const SavedMap& saved, const std::vector<FrameRecord>& frames);

}  // namespace panoptic
