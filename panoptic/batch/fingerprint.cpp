// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/fingerprint.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <vector>

#include "panoptic/bag.h"
#include "panoptic/base/child_process.h"
#include "panoptic/base/files.h"
#include "panoptic/batch/scene_list.h"
#include "panoptic/io/recording_list.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

std::string stamp_of(const fs::directory_entry& file) {
  return fmt::format("{} {} {}", file.path().string(), file.file_size(), file.last_write_time().time_since_epoch().count());
}

std::vector<std::string> stamps_below(const fs::path& path) {
  std::vector<std::string> stamps;
  if (is_file(path)) return {stamp_of(fs::directory_entry(path))};
  if (!is_folder(path)) return stamps;
  for (const auto& entry : fs::recursive_directory_iterator(path, fs::directory_options::follow_directory_symlink)) {
    if (entry.is_regular_file()) stamps.push_back(stamp_of(entry));
  }
  std::sort(stamps.begin(), stamps.end());
  return stamps;
}

}  // namespace

void Fingerprint::add(std::string_view text) {
  const auto take = [&](std::string_view part) {
    hash_ = checksum({reinterpret_cast<const std::uint8_t*>(part.data()), part.size()}, hash_);
  };
  take(fmt::format("{}:", text.size()));
  take(text);
}

void Fingerprint::add_stamps(const fs::path& path) {
  try {
    add(path.string());
    for (const std::string& stamp : stamps_below(path)) add(stamp);
  } catch (const fs::filesystem_error& e) {
    throw FileError(fmt::format("cannot look at the files of {}: {}; check its permissions", path.string(), e.code().message()));
  }
}

void Fingerprint::add_this_program() { add(read_file(kThisProgram)); }

std::string Fingerprint::text() const { return fmt::format("{:016x}", hash_); }

void add_recording(Fingerprint& fingerprint, const std::string& recording) {
  if (is_simulated(recording)) return fingerprint.add(recording);
  const fs::path path = path_of_recording(recording);
  if (path != recording) fingerprint.add(recording);
  fingerprint.add_stamps(path);
  if (!is_recording_list(recording)) return;
  for (const ListedRecording& listed : read_recording_list(recording)) {
    add_recording(fingerprint, listed.recording);
    if (!listed.calibration.empty()) fingerprint.add_stamps(listed.calibration);
    if (!listed.predictions.empty()) fingerprint.add_stamps(listed.predictions);
  }
}

}  // namespace panoptic
