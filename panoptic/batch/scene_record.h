// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The state of a scene of a batch, and the file scene.json in its folder that says so (docs/batch.md). It is removed before
// anything is made and written last, whole or not at all: a scene with such a file is finished, or has failed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "panoptic/base/json.h"
#include "panoptic/batch/scene_list.h"

namespace panoptic {

enum class SceneState { kWaiting, kFinished, kFailed };

struct SceneRecord {
  BatchScene scene;
  std::string fingerprint;  // of the options, the program and the input
  SceneState state = SceneState::kWaiting;
  bool scored = false;  // its labels were compared with the truth
  int attempts = 0;
  double wall_s = 0;   // of the last attempt
  double peak_mb = 0;  // of the largest of its processes
  std::uint64_t frames = 0;
  std::uint64_t objects = 0;
  std::string map_hash;
  std::string reason;  // why it failed; of a finished scene: why it could not be scored
  std::string truth;   // the fingerprint of the truth that it was scored with
};

Json to_json(const SceneRecord& record);

// The record in the folder of the scene; nothing if there is none or it is not readable, as if nothing had been made.
std::optional<SceneRecord> read_record(const std::filesystem::path& folder);
void write_record(const std::filesystem::path& folder, const SceneRecord& record);
void remove_record(const std::filesystem::path& folder);

// True if the scene need not be mapped again.
bool is_finished(const std::optional<SceneRecord>& record, const std::string& fingerprint);

// Takes frames, objects and hash from the files of the run in the folder. Throws Error.
void take_results(const std::filesystem::path& folder, SceneRecord& record);

// The last line in which a program said why it failed ("panoptic: ..."), else the last line that is not empty.
std::string last_error(const std::string& log);

}  // namespace panoptic
