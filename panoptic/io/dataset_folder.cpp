// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Folders of colour images, of depth images and poses, whoever wrote them: Open3D's recorder, Semantic-NeRF's Replica, and what
// somebody has who wants no format. Intrinsics of Semantic-NeRF: https://github.com/Harry-Zhi/semantic_nerf (90 degrees across,
// the principal point in the middle); of the other two: https://github.com/isl-org/Open3D, its RealSense recorder.
#include <fmt/format.h>

#include <array>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/camera_file.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_matching.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 5> kPoseFolders = {"poses", "pose", "extrinsics", "extrinsic", "cam_poses"};

std::optional<std::string> folder_named(const fs::path& root, std::span<const std::string_view> names) {
  return first_named(root, names, [&](const std::string& name) { return is_folder(root / name); });
}

std::optional<std::string> trajectory_log_of_scene(const fs::path& root) {
  const fs::path path = fs::path("scene") / "trajectory.log";  // where Open3D's reconstruction leaves it
  return is_there(root / path) ? std::optional(path.string()) : std::nullopt;
}

void set_cameras(FileRecording& recording) {
  Calibration& calibration = recording.calibration;
  calibration.scale_is_assumed = true;
  calibration.color_is_assumed = recording.format == "plain folder";
  if (const auto file = camera_file_in(recording.root)) return read_camera_file(recording.root / *file, calibration);
  if (recording.format == "Replica (Semantic-NeRF)") {
    calibration.depth = {640, 480, 320, 320, 319.5, 239.5};
    calibration.scale_is_assumed = false;
  }
}

}  // namespace

std::optional<std::string> pose_file_in(const fs::path& folder) {
  constexpr std::array<std::string_view, 14> kNames = {
      "poses.txt",     "pose.txt",        "traj_w_c.txt", "trajectory.log",       "trajectory.txt",   "traj.txt",
      "poses.csv",     "groundtruth.txt", "poses.log",    "cameratrajectory.txt", "camera_poses.txt", "camera_trajectory.txt",
      "cam_poses.txt", "poses_gt.txt"};
  const auto file = first_named(folder, kNames);
  return file ? file : trajectory_log_of_scene(folder);
}

std::optional<FileRecording> recognise_plain_folder(const fs::path& folder, const PairingOptions& pairing) {
  const auto color = folder_named(folder, kColorFolders);
  const auto depth = folder_named(folder, kDepthFolders);
  const auto poses = folder_named(folder, kPoseFolders);
  const auto pose_file = pairing.without_poses ? std::nullopt : pose_file_in(folder);
  if (!color || !depth || (!poses && !pose_file && !pairing.without_poses)) return std::nullopt;
  FileRecording recording{"plain folder", folder, {}, {}};
  const auto camera = camera_file_in(folder);
  if (pose_file && fs::path(*pose_file).filename() == "trajectory.log" && camera && ending_of(*camera) == ".json")
    recording.format = "Open3D recorder";
  if (pose_file == "traj_w_c.txt") recording.format = "Replica (Semantic-NeRF)";
  set_cameras(recording);
  RecordingFiles files{files_in(folder, *color, kColorEndings), files_in(folder, *depth, kDepthEndings), {}};
  require_color_images(folder, *color, files.color);
  if (files.depth.empty()) files.depth = files_in(folder, *depth, kColorEndings);  // the reader says why these are none
  if (!pose_file && poses) files.poses = files_in(folder, *poses, kPoseEndings);
  add_frames_by_name(recording, files);
  if (pose_file) give_poses(recording, read_pose_list(folder / *pose_file), folder / *pose_file);
  return recording;
}

}  // namespace panoptic
