// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs the scenes of a batch, each in processes of its own, several at a time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "panoptic/batch/scene_record.h"

namespace panoptic {

// A program to run for a scene.
struct BatchStep {
  std::vector<std::string> command;
  // A folder that it makes for others too: it is made in `partial` and then gets its name at once. Where it is there already, the
  // step is left out. Empty: it makes nothing of the kind.
  std::filesystem::path made;
  std::filesystem::path partial;
  std::string made_by;  // goes into a file of it, made_by.txt; a folder that says otherwise is a failure
};

// A scene that is to be made, by steps in their order; the first that fails ends it.
struct SceneTask {
  SceneRecord record;  // with what is known of it
  std::filesystem::path folder;
  std::vector<BatchStep> steps;
  std::vector<std::filesystem::path> outdated;  // made from the map: removed before it is mapped or scored anew
  std::string truth;                            // its fingerprint
  bool leaves_map = true;                       // the first steps are a run, which leaves a map and its files in the folder
  bool scores = false;     // the last step compares it with the truth; if that alone fails, the scene is finished for all that
  bool is_mapped = false;  // and that is all that is left to do: the record stays if it is cut short
};

struct BatchWatch {
  std::function<void(const SceneRecord&)> ended;  // finished, or failed for good
  std::function<bool()> go_on;                    // asked many times a second; false ends the programs and the batch
};

inline constexpr int kMostAttempts = 2;  // of a scene: what failed is tried once more

// The record of a finished map is written before it is scored. The first file of the folder is log.txt, with all that the
// programs of the last attempt print; its record is written when the scene has ended. Scenes begin in their order. Call it from
// the main thread. Returns false if it was told to stop: what had not finished then has no record. Throws Error if a folder
// cannot be written.
bool run_scenes(const std::vector<SceneTask>& tasks, int jobs, const BatchWatch& watch);

}  // namespace panoptic
