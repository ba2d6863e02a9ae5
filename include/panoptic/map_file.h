// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map as one SQLite file; docs/map_format.md describes it. Saving and loading gives the same map, bit for bit, with slots and
// epochs. Files are checked from end to end when they are loaded: whatever a file holds, loading it gives a sound map or an Error
// of one line, and takes no more memory than the file could need.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/map.h"
#include "panoptic/options.h"

namespace panoptic {

inline constexpr std::int64_t kMapFormat = 6;  // user_version; one more for each change that older programs cannot read

// A position of the recording that was read: its frame, and whether and how it was used.
struct FrameRecord {
  std::int64_t position = 0;  // counts the positions that were read, from 0
  std::int64_t frame = 0;     // its number in the recording
  double time_s = 0;
  std::optional<Pose> world_from_camera;  // none if it could not be read, or is not finite
  bool labelled = false;                  // it came with a prediction
  std::string unused_because;             // empty: it was used
};

// The part of a map file that never changes.
struct MapHeader {
  MapOptions options;
  LabelSet labels;
};

// Further contents of a map file, for whoever saves it: texts and bytes by name. The names of the format itself
// (docs/map_format.md) are taken.
struct MapNotes {
  std::map<std::string, std::string> texts;
  std::map<std::string, std::vector<std::uint8_t>> states;
};

struct SavedMap {
  MapOptions options;
  PanopticMap map;
  MapNotes notes;
  std::int64_t format = kMapFormat;  // of the file that it was loaded from

  MapHeader header() const { return {options, map.labels}; }
};

// One line for users about a map that was loaded from the file: what its older format lacks. Empty if it lacks nothing.
std::string note_of_format(const SavedMap& saved, const std::filesystem::path& path);

// Loads a map. Throws Error if the file is no sound one. memory_limit_mb and swap_folder of `place` say how the map lies in
// memory; its other members do not matter.
SavedMap load_map(const std::filesystem::path& path, const MapOptions& place = {});
std::vector<FrameRecord> load_frames(const std::filesystem::path& path);

// A whole map at once, with what `saved` holds of options and notes, and the frames that it was made of; the file appears whole
// or not at all, and replaces an older one unless somebody writes that. Throws Error.
void save_map(const std::filesystem::path& path, const SavedMap& saved, const std::vector<FrameRecord>& frames = {});

}  // namespace panoptic
