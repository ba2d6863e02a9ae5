// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Replica as rendered for NICE-SLAM and its successors.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/base/text.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_matching.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

Calibration read_camera_parameters(const fs::path& path) {
  const Json json = read_json_file(path);
  const Json& camera = json.is_object() && json.contains("camera") ? json["camera"] : json;
  const auto number = [&](const char* key, double max) {
    const bool there = camera.is_object() && camera.contains(key) && camera[key].is_number();
    const double value = there ? camera[key].get<double>() : -1;
    if (!(value > 0) || value > max)
      throw Error(fmt::format("{}: '{}' must be a number between 0 and {}", path.string(), key, max));
    return value;
  };
  constexpr double kMaxSide_px = 65536;
  constexpr double kMax = 1e9;
  Calibration calibration;
  calibration.depth = {static_cast<int>(number("w", kMaxSide_px)),
                       static_cast<int>(number("h", kMaxSide_px)),
                       number("fx", kMax),
                       number("fy", kMax),
                       number("cx", kMax),
                       number("cy", kMax)};
  calibration.depth_scale = number("scale", kMax);
  if (calibration.depth.width == 0 || calibration.depth.height == 0)
    throw Error(fmt::format("{}: w and h must be whole numbers", path.string()));
  return calibration;
}

std::vector<std::string> named(const std::vector<std::string>& files, std::string_view prefix) {
  std::vector<std::string> result;
  std::copy_if(files.begin(), files.end(), std::back_inserter(result),
               [&](const std::string& file) { return lower_case(fs::path(file).filename().string()).starts_with(prefix); });
  return result;
}

// Where there are as many lines as frames they belong together in order; else line i belongs to the frame with number i.
void give_lines(FileRecording& recording, const fs::path& trajectory) {
  const PoseList list = read_pose_list(trajectory);
  const std::int64_t first = recording.frames.empty() ? 0 : recording.frames.front().number;
  if (list.key != PoseKey::kNone || list.poses.size() == recording.frames.size()) {
    give_poses(recording, list, trajectory);
    if (first == 0) return;
    recording.assumed.push_back(fmt::format("images are numbered from {}; line 1 of traj.txt is taken for the first", first));
    return;
  }
  for (FileFrame& frame : recording.frames) {
    const auto line = static_cast<std::uint64_t>(frame.number);
    if (line < list.poses.size()) frame.pose = list.poses[line].matrix;
  }
  recording.assumed.push_back(fmt::format("traj.txt has {} lines for {} images: line N + 1 is taken for the image with number N",
                                          list.poses.size(), recording.frames.size()));
}

}  // namespace

std::optional<FileRecording> recognise_replica(const fs::path& folder) {
  if (!is_there(folder / "traj.txt") || !is_folder(folder / "results")) return std::nullopt;
  FileRecording recording{"Replica", folder, {}, {}};
  constexpr double kReplicaScale = 6553.5;
  recording.calibration.depth_scale = kReplicaScale;
  for (const fs::path& place : {folder, folder.parent_path()}) {
    if (!is_there(place / "cam_params.json")) continue;
    recording.calibration = read_camera_parameters(place / "cam_params.json");
    break;
  }
  add_frames_by_name(recording, {named(files_in(folder, "results", kColorEndings), "frame"),
                                 named(files_in(folder, "results", kDepthEndings), "depth"),
                                 {}});
  give_lines(recording, folder / "traj.txt");
  return recording;
}

}  // namespace panoptic
