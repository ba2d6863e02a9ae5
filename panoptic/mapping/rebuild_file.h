// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map file made anew with corrected poses.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "panoptic/pose_update.h"
#include "panoptic/source.h"

namespace panoptic {

// The recording that a map file was made of, as its notes say.
struct MappedRecording {
  std::string recording;    // what open_dataset takes
  std::string calibration;  // empty: none
  std::optional<double> pair_tolerance_s;
  FrameRange range;      // of its positions, which the run read
  bool is_part = false;  // that range was asked for
  bool is_tracked = false;
  bool complete = true;  // the run came to its end
};
// Throws Error: no sound map, or one that was not made by a run.
MappedRecording mapped_recording(const std::filesystem::path& map);

// Whether the log of a map file has copies of all its frames, so that it needs no recording. Throws Error: no sound map.
bool has_copies(const std::filesystem::path& map);

struct RebuiltFile {
  Correction correction;
  std::size_t used = 0;       // frames of the map
  std::size_t given = 0;      // of those, frames that a pose was given for
  std::size_t left_over = 0;  // poses of the file that are of no frame of the map
  std::size_t objects = 0;
};

// Called before each frame that is read from the recording, from any thread, with how many were read and how many there are.
using RebuildProgress = std::function<void(std::size_t done, std::size_t all)>;

// Makes the map anew with the poses of a file (read_corrected_poses), and saves it as another map file, which must not exist. Of
// a complete map the last tasks are done again. `recording` is the one that the map was made of; nullptr: the map's log has
// copies of its frames, which are taken in any case. Throws Error; then there is no new file.
RebuiltFile rebuild_map_file(const std::filesystem::path& map, const std::filesystem::path& poses, const Dataset* recording,
                             const std::filesystem::path& output, const RebuildProgress& progress = {});

}  // namespace panoptic
