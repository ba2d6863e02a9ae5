// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Replica as rendered for NICE-SLAM and its successors.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_formats.h"

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

}  // namespace

std::optional<FileRecording> recognise_replica(const fs::path& folder) {
  constexpr std::array<std::string_view, 2> kColor = {".jpg", ".png"};
  constexpr std::array<std::string_view, 1> kDepth = {".png"};
  if (!is_there(folder / "traj.txt") || !is_folder(folder / "results")) return std::nullopt;
  FileRecording recording{"Replica", folder, {}, {}};
  constexpr double kReplicaScale = 6553.5;
  recording.calibration.depth_scale = kReplicaScale;
  for (const fs::path& place : {folder, folder.parent_path()}) {
    if (!is_there(place / "cam_params.json")) continue;
    recording.calibration = read_camera_parameters(place / "cam_params.json");
    break;
  }
  recording.frames =
      joined(numbered_files(folder, "results", "frame", kColor), numbered_files(folder, "results", "depth", kDepth), {});
  const std::vector<Eigen::Matrix4d> poses = read_matrix_lines(folder / "traj.txt");
  for (FileFrame& frame : recording.frames) {  // line i belongs to the frame with number i
    if (static_cast<std::uint64_t>(frame.number) < poses.size()) frame.pose = poses[static_cast<std::size_t>(frame.number)];
  }
  return recording;
}

}  // namespace panoptic
