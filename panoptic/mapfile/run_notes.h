// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The notes of a map file about the run that made it (docs/map_format.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "panoptic/geometry.h"
#include "panoptic/map/frame_votes.h"
#include "panoptic/map/maintenance_state.h"
#include "panoptic/map/presence_state.h"
#include "panoptic/map_file.h"

namespace panoptic {

// Names of the texts that tell of the run.
namespace run_note {
inline constexpr const char* kRecording = "recording";
inline constexpr const char* kRecordings = "recordings";  // of a list
inline constexpr const char* kCalibration = "calibration";
inline constexpr const char* kPairTolerance = "pair_tolerance_s";
inline constexpr const char* kPoseUpdates = "pose_updates";
inline constexpr const char* kFrames = "frames_range";
inline constexpr const char* kOptions = "options";
inline constexpr const char* kPositions = "positions";
inline constexpr const char* kComplete = "complete";
inline constexpr const char* kUp = "up";
inline constexpr const char* kProgram = "program";
inline constexpr const char* kOnline = "online";
inline constexpr const char* kTracked = "tracked";         // its poses were found by the run
inline constexpr const char* kMerged = "merged";           // two maps as one (map_pairs.h)
inline constexpr const char* kRebuilt = "rebuilt";         // with these corrected poses (rebuild_file.h)
inline constexpr const char* kFromFormat = "from_format";  // saved anew from a file of an older format: that one's number
}  // namespace run_note

// The text of that name; empty if the map has none.
std::string note_or_empty(const SavedMap& saved, const std::string& name);

// True if a map holds its recording to the end, the last tasks of the mapper included; else it is a checkpoint.
bool is_complete(const SavedMap& saved);
// The upward direction of the world, unit length, and its text in the notes.
Vec3d up_of(const SavedMap& saved);
std::string up_text(const Vec3d& up);
// A number among the options of the run, by its key ("depth.max_m"). Throws Error: the options are no TOML.
std::optional<double> option_of(const SavedMap& saved, std::string_view key);

// The state of a mapper beside its map, except for its frames, which the file lists one by one.
struct SavedState {
  MaintenanceState maintenance;
  RegularizerState regularizer;
  MovingState moving;
  PresenceState presence;
  std::uint64_t label_frames = 0;
  std::uint64_t labelled = 0;
  Vec3d up_sum = Vec3d::Zero();
  std::int64_t last_frame = 0;
};

MapNotes notes_of(const SavedState& state);

// Reads that state. Throws Error if the notes are not of the map beside them.
SavedState saved_state(const SavedMap& saved);

}  // namespace panoptic
