// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Two map files as one.
//   merge_map_files("morning.panoptic", "evening.panoptic", "day.panoptic");
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/map/map_merge.h"

namespace panoptic {

MapWithFrames load_map_with_frames(const std::filesystem::path& path);

struct MergedFiles {
  std::size_t objects_a = 0;
  std::size_t objects_b = 0;
  std::size_t objects = 0;
  std::size_t same = 0;   // objects that both maps have
  std::size_t parts = 0;  // objects that are parts of one in the other map
  std::size_t blocks = 0;
  std::vector<std::string> notes;  // what a file of an older format lacks, a line each
};

// Merges (map/map_merge.h) and writes the result, whole or not at all. It is a finished map: info, mesh, query, eval, view,
// merge, diff and regularize work on it, a run cannot go on from it. Regularizing starts from the labels as merged: what the
// regularizer overruled in the two maps is not kept. Options are those of `a`. Throws Error: not comparable, or `merged` is
// there.
MergedFiles merge_map_files(const std::filesystem::path& a, const std::filesystem::path& b, const std::filesystem::path& merged);

}  // namespace panoptic
