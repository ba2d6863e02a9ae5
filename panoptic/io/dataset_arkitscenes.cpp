// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of ARKitScenes (https://github.com/apple/ARKitScenes), raw or of its 3dod subset: images that are called
// VIDEO_SECONDS.png, intrinsics for each, and lowres_wide.traj. The files and their units are those of its DATA.md. That a line
// of the trajectory takes points of the world to the camera (x right, y down, z forward), and that the names of intrinsics are up
// to a millisecond off, is from threedod/benchmark_scripts/utils/tenFpsDataLoader.py.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/time_pairing.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr double kSameTime_s = 0.005;  // images come 60 times a second, and names are rounded to a millisecond
constexpr const char* kDepthFolder = "lowres_depth";
constexpr const char* kTrajectory = "lowres_wide.traj";

struct TimedFile {
  double time_s = 0;
  std::string path;
};

// "47333462_65.123.png": what follows the last underscore.
std::optional<double> time_in(const std::string& path) {
  const std::string stem = fs::path(path).stem().string();
  const std::optional<double> time_s = to_number(stem.substr(stem.rfind('_') + 1));
  return time_s && std::isfinite(*time_s) ? time_s : std::nullopt;
}

std::vector<TimedFile> timed_files(const fs::path& root, const std::string& folder, std::string_view ending) {
  std::vector<TimedFile> files;
  for (const std::string& path : files_in(root, folder, std::array{ending})) {
    if (const auto time_s = time_in(path)) files.push_back({*time_s, path});
  }
  std::stable_sort(files.begin(), files.end(), [](const TimedFile& a, const TimedFile& b) { return a.time_s < b.time_s; });
  return files;
}

std::vector<double> times_of(const std::vector<TimedFile>& files) {
  std::vector<double> times_s;
  for (const TimedFile& file : files) times_s.push_back(file.time_s);
  return times_s;
}

// The file of this time; empty if there is none.
std::string file_at(const std::vector<TimedFile>& files, double time_s) {
  const auto after =
      std::lower_bound(files.begin(), files.end(), time_s, [](const TimedFile& file, double time) { return file.time_s < time; });
  const TimedFile* best = nullptr;
  for (const auto it : {after == files.begin() ? after : std::prev(after), after}) {
    if (it != files.end() && (best == nullptr || std::abs(it->time_s - time_s) < std::abs(best->time_s - time_s))) best = &*it;
  }
  return best != nullptr && std::abs(best->time_s - time_s) <= kSameTime_s ? best->path : "";
}

// width height fx fy cx cy
Camera read_pincam(const fs::path& path) {
  constexpr double kMaxSide_px = 65536;
  const std::vector<double> n = read_numbers(path);
  if (n.size() != 6) throw Error(fmt::format("{}: {} numbers, expected width height fx fy cx cy", path.string(), n.size()));
  for (const double side : {n[0], n[1]}) {
    if (!(side >= 1 && side <= kMaxSide_px) || side != std::floor(side))
      throw Error(fmt::format("{}: {} is no image size", path.string(), side));
  }
  Camera camera = to_camera(std::span(n).subspan(2), path.string());
  camera.width = static_cast<int>(n[0]);
  camera.height = static_cast<int>(n[1]);
  return camera;
}

// A line each: seconds, the rotation as an axis times its angle, the translation. All are inverted to world from camera.
std::vector<PoseSample> read_trajectory(const fs::path& path) {
  constexpr std::size_t kColumns = 7;
  std::vector<PoseSample> poses;
  for_each_line(path, [&](std::size_t line, std::span<const std::string_view> words) {
    if (words.size() != kColumns)
      throw Error(fmt::format("{}:{}: expected 'time rx ry rz tx ty tz', found {} words", path.string(), line, words.size()));
    const std::vector<double> n = to_numbers(words, path, line);
    if (!std::isfinite(n[0])) throw Error(fmt::format("{}:{}: expected a time, found '{}'", path.string(), line, words[0]));
    const Vec3d turn(n[1], n[2], n[3]);
    const double angle = turn.norm();
    const Vec3d axis = angle > 0 ? Vec3d(turn / angle) : Vec3d::UnitX();
    const Eigen::Quaterniond world_from_camera(Eigen::AngleAxisd(-angle, axis));
    poses.push_back({n[0], -(world_from_camera * Vec3d(n[4], n[5], n[6])), world_from_camera});
  });
  std::stable_sort(poses.begin(), poses.end(), [](const PoseSample& a, const PoseSample& b) { return a.time_s < b.time_s; });
  return poses;
}

// The folder itself, or VIDEO_frames in it, where the 3dod subset has them.
std::optional<fs::path> scene_folder(const fs::path& folder) {
  if (is_folder(folder / kDepthFolder)) return folder;
  for (const std::string& name : names_in_folder(folder)) {
    if (name.ends_with("_frames") && is_folder(folder / name / kDepthFolder)) return folder / name;
  }
  return std::nullopt;
}

// The images of the camera that depth is registered to, the smallest first: those come as often as depth does.
std::optional<std::string> color_folder(const fs::path& root) {
  for (const char* name : {"lowres_wide", "vga_wide", "wide"}) {
    if (is_folder(root / name)) return name;
  }
  return std::nullopt;
}

void add_frames(FileRecording& recording, const std::string& color_kind, double tolerance_s) {
  const std::vector<TimedFile> color = timed_files(recording.root, color_kind, ".png");
  const std::vector<TimedFile> depth = timed_files(recording.root, kDepthFolder, ".png");
  for (const TimePair& pair : paired_by_time(times_of(color), times_of(depth), tolerance_s)) {
    FileFrame frame;
    frame.time_s = pair.depth ? depth[*pair.depth].time_s : color[*pair.color].time_s;
    if (pair.color) frame.color = color[*pair.color].path;
    if (pair.depth) frame.depth = depth[*pair.depth].path;
    if (!pair.depth) frame.problem = fmt::format("no depth image within {} s", tolerance_s);
    if (!pair.color) frame.problem = fmt::format("no colour image within {} s", tolerance_s);
    recording.frames.push_back(std::move(frame));
  }
  std::stable_sort(recording.frames.begin(), recording.frames.end(),
                   [](const FileFrame& a, const FileFrame& b) { return a.time_s < b.time_s; });
  for (std::size_t i = 0; i < recording.frames.size(); ++i) recording.frames[i].number = static_cast<std::int64_t>(i);
  const auto has_both = [](const FileFrame& frame) { return !frame.color.empty() && !frame.depth.empty(); };
  if (std::any_of(recording.frames.begin(), recording.frames.end(), has_both)) return;
  throw Error(
      fmt::format("{}: no image in {}/ lies within {} s of one in {}/ ({} and {} images called VIDEO_SECONDS.png); download "
                  "both of one scene, or allow more with --pair-tolerance S",
                  recording.root.string(), color_kind, tolerance_s, kDepthFolder, color.size(), depth.size()));
}

void give_cameras(FileRecording& recording, const std::string& folder) {
  const std::vector<TimedFile> files = timed_files(recording.root, folder, ".pincam");
  for (FileFrame& frame : recording.frames) {
    if (files.empty() || !frame.problem.empty()) continue;
    const std::string file = file_at(files, time_in(frame.color).value_or(frame.time_s));
    try {
      if (file.empty()) frame.problem = fmt::format("no intrinsics within {} s in {}/", kSameTime_s, folder);
      if (!file.empty()) frame.camera = read_pincam(recording.root / file);
    } catch (const Error& e) {
      frame.problem = fmt::format("no intrinsics that can be read: {}", e.what());
    }
    if (frame.camera && recording.calibration.depth.width == 0) recording.calibration.depth = *frame.camera;
  }
}

void give_confidence(FileRecording& recording) {
  const std::vector<TimedFile> files = timed_files(recording.root, "confidence", ".png");
  recording.has_confidence = !files.empty();
  for (FileFrame& frame : recording.frames) frame.confidence = file_at(files, frame.time_s);
  if (files.empty())
    recording.assumed.emplace_back("every depth reading is as sure as others: there are no images in confidence/");
}

void give_poses(FileRecording& recording) {
  const fs::path path = recording.root / kTrajectory;
  const std::vector<PoseSample> poses = read_trajectory(path);
  bool found = false;
  for (FileFrame& frame : recording.frames) {
    frame.pose = pose_at(poses, frame.time_s, kMaxPoseGap_s);
    found = found || frame.pose.has_value();
    if (!frame.pose && frame.problem.empty()) {
      frame.problem =
          fmt::format("no pose: none within {} s, nor two less than {} s apart around it", kMaxTimeDifference_s, kMaxPoseGap_s);
    }
  }
  if (found || recording.frames.empty()) return;
  throw Error(
      fmt::format("{}: none of its {} poses is of the time of an image (from {:.3f} to {:.3f} s); is it of the same scene?",
                  path.string(), poses.size(), recording.frames.front().time_s, recording.frames.back().time_s));
}

}  // namespace

std::optional<FileRecording> recognise_arkitscenes(const fs::path& folder, const PairingOptions& pairing) {
  const std::optional<fs::path> root = scene_folder(folder);
  const std::optional<std::string> color = root ? color_folder(*root) : std::nullopt;
  if (!color) return std::nullopt;
  FileRecording recording{"ARKitScenes", *root, {}, {}};
  add_frames(recording, *color, pairing.tolerance_s.value_or(kSameTime_s));
  give_cameras(recording, *color + "_intrinsics");
  give_confidence(recording);
  if (pairing.without_poses) return recording;
  if (!is_there(*root / kTrajectory)) {
    throw NoPoses(fmt::format("{}: ARKitScenes scene without {}; download it, or let panoptic run --track find the poses",
                              root->string(), kTrajectory));
  }
  give_poses(recording);
  return recording;
}

}  // namespace panoptic
