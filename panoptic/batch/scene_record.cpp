// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/scene_record.h"

#include <algorithm>
#include <array>
#include <sstream>

#include "panoptic/base/files.h"
#include "panoptic/run_files.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "scene.json";
constexpr std::array<const char*, 3> kStates = {"waiting", "finished", "failed"};

std::optional<SceneRecord> from_json(const Json& json) {
  SceneRecord record;
  record.scene = {json.at("name"), json.at("recording")};
  record.fingerprint = json.at("fingerprint");
  const std::string state = json.at("state");
  const auto place = std::find(kStates.begin(), kStates.end(), state);
  if (place == kStates.end()) return std::nullopt;
  record.state = static_cast<SceneState>(place - kStates.begin());
  record.scored = json.at("scored");
  record.attempts = json.at("attempts");
  record.wall_s = json.at("wall_s");
  record.peak_mb = json.at("peak_mb");
  record.frames = json.at("frames");
  record.objects = json.at("objects");
  record.map_hash = json.at("map_hash");
  record.reason = json.at("reason");
  record.truth = json.at("truth");
  return record;
}

}  // namespace

Json to_json(const SceneRecord& r) {
  return {{"name", r.scene.name},
          {"recording", r.scene.recording},
          {"fingerprint", r.fingerprint},
          {"state", kStates.at(static_cast<std::size_t>(r.state))},
          {"scored", r.scored},
          {"attempts", r.attempts},
          {"wall_s", r.wall_s},
          {"peak_mb", r.peak_mb},
          {"frames", r.frames},
          {"objects", r.objects},
          {"map_hash", r.map_hash},
          {"reason", r.reason},
          {"truth", r.truth}};
}

std::optional<SceneRecord> read_record(const fs::path& folder) {
  if (!is_file(folder / kFile)) return std::nullopt;
  const std::optional<Json> json = json_in(read_file(folder / kFile));
  if (!json) return std::nullopt;
  try {
    return from_json(*json);
  } catch (const Json::exception&) {
    return std::nullopt;  // by another version
  }
}

void write_record(const fs::path& folder, const SceneRecord& record) { write_json_file(folder / kFile, to_json(record)); }

void remove_record(const fs::path& folder) { os::remove(folder / kFile); }

bool is_finished(const std::optional<SceneRecord>& record, const std::string& fingerprint) {
  return record && record->state == SceneState::kFinished && record->fingerprint == fingerprint;
}

void take_results(const fs::path& folder, SceneRecord& record) {
  record.frames = read_run_report(folder).frames_used;
  record.objects = read_run_objects(folder).objects.size();
  record.map_hash = read_json_file(folder / "report.json").value("map_hash", "");
}

std::string last_error(const std::string& log) {
  constexpr const char* kMark = "panoptic: ";
  std::string last;
  std::string error;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(line.find_last_of('\r') + 1);  // a progress bar begins its line anew
    if (line.empty()) continue;
    last = line;
    if (line.starts_with(kMark)) error = line.substr(std::string(kMark).size());
  }
  return error.empty() ? last : error;
}

}  // namespace panoptic
