// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_order.h"
#include "panoptic/io/recording_list.h"
#include "panoptic/io/sens.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

struct FolderFormat {
  const char* looked_for = "";
  std::optional<FileRecording> (*recognise)(const fs::path& folder) = nullptr;
  std::optional<FileRecording> (*recognise_as)(const fs::path& folder, const PairingOptions& pairing) = nullptr;
  bool is_paired_by_time = false;

  std::optional<FileRecording> operator()(const fs::path& folder, const PairingOptions& pairing) const {
    return recognise_as != nullptr ? recognise_as(folder, pairing) : recognise(folder);
  }
};

// Formats in the order in which they are tried: the more telling layouts first.
constexpr std::array<FolderFormat, 12> kFolderFormats = {{
    {"ScanNet export (color/, depth/, pose/ or poses/, also under frames/)", recognise_scannet_export},
    {"ScanNet C++ export (_info.txt, frame-*.depth.pgm) or BundleFusion (info.txt, frame-*.depth.png)",
     recognise_scannet_cpp_export},
    {"7-Scenes or 3DMatch (frame-*.depth.png, or a seq-XX folder of them)", recognise_seven_scenes},
    {"TUM RGB-D (rgb.txt and depth.txt, or associations.txt)", nullptr, recognise_tum, true},
    {"Replica (traj.txt, results/)", recognise_replica},
    {"ARKitScenes (lowres_wide/, lowres_depth/, lowres_wide.traj)", nullptr, recognise_arkitscenes, true},
    {"Stray Scanner (odometry.csv, camera_matrix.csv, depth/, rgb.mp4 or rgb/)", nullptr, recognise_stray},
    {"Record3D (metadata.json, rgb/, depth/, also in EXR_RGBD/)", recognise_record3d},
    {"RTAB-Map export (rgb/, depth/, calib/, camera_poses.txt, also after a name)", nullptr, recognise_rtabmap},
    {"SUN3D (image/, depth/, extrinsics/, intrinsics.txt)", nullptr, recognise_sun3d},
    {"plain folder (images/, depth/, poses.txt or poses/, K.txt), also of Open3D's recorder and Semantic-NeRF", nullptr,
     recognise_plain_folder},
    {"flat folder (00000.jpg, 00000.png, 00000.txt, intrinsic.txt)", nullptr, recognise_flat_folder},
}};

fs::path without_trailing_slash(const fs::path& path) {
  const fs::path clean = fs::absolute(path).lexically_normal();
  return clean.has_filename() ? clean : clean.parent_path();
}

// The file itself, or the only one in the folder.
std::optional<fs::path> find_sens_file(const fs::path& path) {
  if (is_file(path)) return ending_of(path) == ".sens" ? std::optional(path) : std::nullopt;
  std::vector<fs::path> files;
  for (const std::string& name : names_in_folder(path)) {
    if (ending_of(name) == ".sens" && !name.starts_with('.')) files.push_back(path / name);
  }
  if (files.size() > 1) throw Error(fmt::format("{}: holds {} .sens files; name one of them", path.string(), files.size()));
  return files.empty() ? std::nullopt : std::optional(files.front());
}

[[noreturn]] void not_recognised(const fs::path& path) {
  const std::string why = why_no_recording(path);
  if (!why.empty()) throw Error(fmt::format("{}: no recording of a known format; {}", path.string(), why));
  std::string formats = "a .sens file; a bag (.bag, .mcap, .db3); a list of recordings (a .toml file)";
  for (const FolderFormat& format : kFolderFormats) formats += fmt::format("; {}", format.looked_for);
  throw Error(fmt::format("{}: no recording of a known format; looked for {}", path.string(), formats));
}

[[noreturn]] void refuse_pairing(const fs::path& path, const std::string& format) {
  throw Error(fmt::format("{}: images of a {} recording are not paired by their time stamps; leave out --pair-tolerance",
                          path.string(), format));
}

// "run.bag?depth=/camera/depth": a bag, and which of its topics to take.
std::unique_ptr<Dataset> open_with_choice(const std::string& name, const fs::path& calibration, const PairingOptions& pairing) {
  const fs::path bag = path_of_recording(name);
  return open_bag_as(bag, parse_bag_choice(name.substr(bag.native().size() + 1)), calibration, pairing);
}

// Reads a calibration file. Cameras that it gives hold for all frames.
void override_calibration(FileRecording& recording, const fs::path& path) {
  const Calibration before = recording.calibration;
  Calibration& now = recording.calibration;
  read_calibration(path, now);
  const bool has_cameras = now.depth != before.depth || now.color != before.color || now.color_distortion.has_value() ||
                           now.depth_distortion != before.depth_distortion;
  bool had_own = false;
  for (FileFrame& frame : recording.frames) {
    if (!has_cameras) break;
    had_own = had_own || frame.camera.has_value();
    frame.camera.reset();
    if (frame.problem.starts_with("no intrinsics")) frame.problem.clear();
  }
  if (had_own) {
    recording.assumed.push_back(
        fmt::format("the intrinsics in {} hold for all frames, in place of each one's own", path.string()));
  }
}

void forget_poses(FileRecording& recording) {
  for (FileFrame& frame : recording.frames) {
    frame.pose = Eigen::Matrix4d::Identity();
    if (frame.problem.starts_with("no pose")) frame.problem.clear();
  }
  recording.other_order = {};
}

[[noreturn]] void refuse_as_unposed(const FileRecording& recording) {
  throw NoPoses(
      fmt::format("{}: {} recording without poses; panoptic run --track finds them", recording.root.string(), recording.format));
}

void require_poses(const FileRecording& recording) {
  const auto has_pose = [](const FileFrame& frame) { return frame.pose || !frame.pose_file.empty(); };
  if (recording.frames.empty() || std::any_of(recording.frames.begin(), recording.frames.end(), has_pose)) return;
  refuse_as_unposed(recording);
}

// Says so where a folder would be a recording, had it poses.
void refuse_without_poses(const fs::path& path, const PairingOptions& pairing) {
  if (pairing.without_poses || has_unread_poses(path)) return;
  for (const auto& recognise : {recognise_sun3d, recognise_plain_folder, recognise_flat_folder}) {
    const auto recording = recognise(path, {.tolerance_s = {}, .without_poses = true});
    if (recording && !recording->frames.empty()) refuse_as_unposed(*recording);
  }
}

std::unique_ptr<Dataset> open_absolute(const fs::path& path, const fs::path& calibration, const PairingOptions& pairing) {
  if (!is_there(path)) throw Error(fmt::format("{}: no such file or folder; give the path of a recording", path.string()));
  if (const auto sens = find_sens_file(path)) {
    if (pairing.tolerance_s) refuse_pairing(path, ".sens");
    return std::make_unique<SensDataset>(*sens, calibration, pairing.without_poses);
  }
  if (is_file(path) && is_bag_recording(path)) return open_bag_as(path, {}, calibration, pairing);
  if (!is_folder(path)) not_recognised(path);
  for (const FolderFormat& format : kFolderFormats) {
    std::optional<FileRecording> recording = format(path, pairing);
    if (!recording) continue;
    if (pairing.tolerance_s && !format.is_paired_by_time) refuse_pairing(path, recording->format);
    if (!calibration.empty()) override_calibration(*recording, calibration);
    pairing.without_poses ? forget_poses(*recording) : require_poses(*recording);
    settle_pose_order(*recording);
    return std::make_unique<FileDataset>(std::move(*recording));
  }
  if (is_bag_recording(path)) return open_bag_as(path, {}, calibration, pairing);
  refuse_without_poses(path, pairing);
  not_recognised(path);
}

std::unique_ptr<Dataset> open_readable(const fs::path& path, const fs::path& calibration, const PairingOptions& pairing) {
  try {
    if (path_of_recording(path.native()) != path) return open_with_choice(path.native(), calibration, pairing);
    return open_absolute(without_trailing_slash(path), calibration, pairing);
  } catch (const fs::filesystem_error& e) {  // a folder without permission, for one
    throw Error(fmt::format("cannot open {}: {}; check the path and its permissions", path.string(), e.code().message()));
  }
}

}  // namespace

std::unique_ptr<Dataset> open_recording(const fs::path& path, const fs::path& calibration,
                                        std::optional<double> pair_tolerance_s) {
  if (path.native().starts_with("sim:") && !is_there(path)) {
    throw Error(
        fmt::format("{}: a simulated home, and the simulator is not part of this: it is panoptic::simulation "
                    "(-DPANOPTIC_SIM=ON), and open_dataset opens it",
                    path.string()));
  }
  if (is_recording_list(path)) {
    return open_recording_list(path, calibration, pair_tolerance_s, [](const ListedRecording& r) {
      require_posed(r);
      return open_recording(r.recording, r.calibration, r.pair_tolerance_s);
    });
  }
  return open_readable(path, calibration, {.tolerance_s = pair_tolerance_s});
}

std::unique_ptr<Dataset> open_without_poses(const fs::path& path, const fs::path& calibration,
                                            std::optional<double> pair_tolerance_s) {
  if (is_recording_list(path)) {
    throw Error(fmt::format("{}: a list of recordings, and a camera is tracked in one; name one of them", path.string()));
  }
  return open_readable(path, calibration, {.tolerance_s = pair_tolerance_s, .without_poses = true});
}

}  // namespace panoptic
