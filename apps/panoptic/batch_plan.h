// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The commands of a batch: which programs run for each scene, and whether it is finished already.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/panoptic/arguments.h"
#include "panoptic/batch/batch_run.h"

namespace panoptic {

struct BatchPlan {
  std::vector<SceneRecord> records;  // of all scenes, in their order
  std::vector<SceneTask> tasks;      // of all scenes, until leave_out_finished
  std::vector<std::string> left_out;
};

// Looks at everything that can be wrong before hours are spent: the list, the options of the runs, models, predictions of others,
// truth that is missing. `only`: the name of the one scene to look at; empty = all. Throws UsageError, Error.
BatchPlan plan_batch(const Arguments& arguments, const std::string& only = "");

// Takes the records of what is finished, whose tasks go. Call it when nobody else writes the folders any more. Throws FileError.
void leave_out_finished(BatchPlan& plan);

// Submits the scenes that are not finished to Slurm, and tells of it. Throws Error.
void submit_batch(const Arguments& arguments, const BatchPlan& plan);

// The name of the scene that a task of a submitted batch has. Throws Error.
std::string scene_of_task(const Arguments& arguments);

// Throws Error if a batch that was submitted earlier for the same folder is not done.
void require_no_submission(const Arguments& arguments);

// Removes the scores of an earlier batch.
void remove_batch_scores(const std::filesystem::path& output);

// The scores of all scenes that were compared with their truth, accumulated as in the benchmarks, in scores.json and
// scores.csv; the table. Empty without such scenes. Throws Error.
std::string write_batch_scores(const std::filesystem::path& output, const std::vector<SceneRecord>& records);

}  // namespace panoptic
