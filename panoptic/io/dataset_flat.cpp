// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Colour, depth and poses side by side in one folder, told apart by a word in the name or by the ending: 00000.jpg, 00000.png,
// 00000.txt (posed images of mmdetection3d); 0001-color.png, 0001-depth.png, 0001.pose.txt.
#include <algorithm>
#include <array>

#include "panoptic/base/files.h"
#include "panoptic/io/camera_file.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_matching.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

bool has_word(const std::string& name, std::span<const std::string_view> words) {
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) { return name.find(word) != std::string::npos; });
}

bool has_number(const std::string& name) { return name.find_first_of("0123456789") != std::string::npos; }

// Colour and depth by a word in the name; without one, JPEGs are colour and what else lies beside them is depth.
RecordingFiles sorted_out(const fs::path& folder) {
  constexpr std::array<std::string_view, 1> kDepthWords = {"depth"};
  constexpr std::array<std::string_view, 4> kColorWords = {"color", "colour", "rgb", "image"};
  constexpr std::array<std::string_view, 6> kOtherWords = {"label", "instance", "mask", "semantic", "normal", "_vis"};
  constexpr std::array<std::string_view, 7> kEndings = {".png", ".jpg", ".jpeg", ".pgm", ".tif", ".tiff", ".npy"};
  RecordingFiles files;
  std::vector<std::string> unnamed_png;
  for (const std::string& file : files_in(folder, "", kEndings)) {
    const std::string name = fs::path(file).filename().string();
    const std::string ending = ending_of(file);
    const bool is_jpeg = ending == ".jpg" || ending == ".jpeg";
    if (!has_number(name) || has_word(name, kOtherWords)) continue;
    if (has_word(name, kDepthWords)) {
      files.depth.push_back(file);
    } else if (is_jpeg || (ending == ".png" && has_word(name, kColorWords))) {
      files.color.push_back(file);
    } else {
      unnamed_png.push_back(file);
    }
  }
  if (files.depth.empty()) files.depth = unnamed_png;
  if (files.color.empty()) files.color = unnamed_png;
  for (const std::string& file : files_in(folder, "", kPoseEndings)) {
    if (has_number(fs::path(file).stem().string()) && file != "_info.txt") files.poses.push_back(file);
  }
  return files;
}

}  // namespace

std::optional<FileRecording> recognise_flat_folder(const fs::path& folder, const PairingOptions& pairing) {
  RecordingFiles files = sorted_out(folder);
  const auto pose_file = pairing.without_poses ? std::nullopt : pose_file_in(folder);
  const bool has_poses = !files.poses.empty() || pose_file || pairing.without_poses;
  if (files.color.empty() || files.depth.empty() || files.color == files.depth || !has_poses) return std::nullopt;
  FileRecording recording{"flat folder", folder, {}, {}};
  recording.calibration.scale_is_assumed = true;
  recording.calibration.color_is_assumed = true;
  if (const auto camera = camera_file_in(folder)) read_camera_file(folder / *camera, recording.calibration);
  if (pose_file) files.poses.clear();
  add_frames_by_name(recording, files);
  if (pose_file) give_poses(recording, read_pose_list(folder / *pose_file), folder / *pose_file);
  return recording;
}

}  // namespace panoptic
