// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// batch.json and batch.md: how a batch stands (docs/batch.md).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/batch/scene_record.h"

namespace panoptic {

struct BatchReport {
  std::string list;                      // as it was named
  std::vector<std::string> run_options;  // as they were given
  int jobs = 1;
  double wall_s = 0;                // of this call
  std::size_t skipped = 0;          // scenes that were finished before
  std::vector<SceneRecord> scenes;  // in the order of the list
  std::string scores;               // the accumulated table; empty = none
};

std::size_t count(const BatchReport& report, SceneState state);

// Finished scenes that could not be scored.
std::size_t count_unscored(const BatchReport& report);

// Whether every scene is finished, and its scoring did not fail.
bool is_complete(const BatchReport& report);

// Writes both files into the folder, each whole or not at all. Throws FileError.
void write_batch_report(const std::filesystem::path& folder, const BatchReport& report);

}  // namespace panoptic
