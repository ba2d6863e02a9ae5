// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/map_result.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "apps/panoptic/commands.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/mapping/checkpoint.h"

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

}  // namespace panoptic
