// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/map_result.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "apps/panoptic/commands.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/saved_snapshot.h"

namespace panoptic {

bool is_map_file(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

LabelledMap map_to_score(const std::string& path, std::vector<std::string>& warnings) {
  const SavedMap saved = load_map_and_tell(path);
  LabelledMap map = labelled_map(saved.map, mesh_of(saved), &warnings);
  if (!is_complete(saved)) {
    warnings.push_back(fmt::format("{}: a checkpoint; this is the map of the first frames of its recording", path));
  }
  return map;
}

// Opens a map file by way of a mapper with its state, so that the map looks as in the run that wrote it.
OpenedResult open_map_result(const std::string& path) {
  SavedMap saved = load_map(path);
  const std::vector<FrameRecord> frames = load_frames(path);
  SceneHistory history = history_of(saved, frames);
  SavedSnapshot opened = open_snapshot(std::move(saved), frames, path);
  tell_note(opened.note);
  return {std::move(opened.scene), std::move(opened.snapshot), std::move(history)};
}

}  // namespace panoptic
