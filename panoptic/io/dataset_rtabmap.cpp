// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// An export of RTAB-Map (https://github.com/introlab/rtabmap): NAME_rgb/, NAME_depth/ and NAME_calib/ with a YAML file for each
// image, and NAME_camera_poses.txt, or NAME_poses.txt, which are the robot's. Names and lines are those of its
// tools/Export/main.cpp (rtabmap-export --images_id --poses_camera): a pose is "stamp x y z qx qy qz qw id", images are called by
// that id, or by the stamp; the pose of the camera (x right, y down, z forward) is that of the robot times the local_transform of
// the calibration. The graphical tools leave NAME_ out.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/camera_file.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/dataset_frame.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_list.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr double kSameStamp_s = 1e-4;  // stamps have six decimals
constexpr const char* kHowToExport = "rtabmap-export --images_id --poses_camera DATABASE.db";

// One YAML file, as OpenCV writes it.
struct CalibrationFile {
  Camera camera;
  Distortion distortion;
  Eigen::Matrix4d robot_from_camera = Eigen::Matrix4d::Identity();
};

// The text after "key:" at the begin of a line; empty if there is none.
std::string_view after_key(std::string_view text, std::string_view key) {
  const std::string wanted = fmt::format("\n{}:", key);
  const std::size_t at = text.find(wanted);
  return at == std::string_view::npos ? std::string_view() : text.substr(at + wanted.size());
}

// The numbers in the brackets of a matrix; none if there is no such matrix.
std::vector<double> matrix_in(std::string_view text, std::string_view key, const fs::path& path) {
  const std::string_view section = after_key(text, key);
  const std::size_t open = section.find('[');
  const std::size_t close = section.find(']');
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return {};
  return numbers_in(section.substr(open, close - open + 1), path);
}

int side_in(std::string_view text, std::string_view key, const fs::path& path) {
  constexpr double kMaxSide_px = 65536;
  const std::string_view section = after_key(text, key);
  const std::vector<double> numbers = numbers_in(section.substr(0, section.find('\n')), path);
  if (numbers.size() != 1 || !(numbers[0] >= 1 && numbers[0] <= kMaxSide_px))
    throw Error(fmt::format("{}: no {}; export it again: {}", path.string(), key, kHowToExport));
  return static_cast<int>(numbers[0]);
}

// Some versions wrote the first nine numbers of the projection matrix into camera_matrix; the maintainer's way out is to take
// that one instead (https://github.com/introlab/rtabmap/issues/1253).
Camera camera_in(std::string_view text, const fs::path& path) {
  const std::vector<double> matrix = matrix_in(text, "camera_matrix", path);
  constexpr std::size_t kLast = 8;
  const bool is_whole = matrix.size() == kLast + 1 && matrix[kLast] == 1;
  return to_camera(is_whole ? matrix : matrix_in(text, "projection_matrix", path), path.string());
}

CalibrationFile read_calibration_file(const fs::path& path) {
  const std::string text = "\n" + read_file(path);
  CalibrationFile file;
  file.camera = camera_in(text, path);
  file.camera.width = side_in(text, "image_width", path);
  file.camera.height = side_in(text, "image_height", path);
  const std::string_view model = after_key(text, "distortion_model");
  std::string name(model.substr(0, model.find('\n')));
  std::erase_if(name, [](char c) { return c == ' ' || c == '\r' || c == '"'; });
  file.distortion = to_distortion(name, matrix_in(text, "distortion_coefficients", path), path.string());
  const std::vector<double> local = matrix_in(text, "local_transform", path);
  const auto transform = to_matrix(local);
  if (transform && check_pose(*transform).used) file.robot_from_camera = *transform;
  if (!local.empty() && (!transform || !check_pose(*transform).used))
    throw Error(fmt::format("{}: local_transform is no rigid transform; export it again: {}", path.string(), kHowToExport));
  return file;
}

struct StampedPose {
  double time_s = 0;
  std::optional<std::int64_t> id;
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
};

std::vector<StampedPose> read_poses(const fs::path& path) {
  constexpr std::size_t kColumns = 8;
  std::vector<StampedPose> poses;
  for_each_line(path, [&](std::size_t line, std::span<const std::string_view> words) {
    if (words.size() != kColumns && words.size() != kColumns + 1) {
      throw Error(fmt::format("{}:{}: {} words, expected 'stamp x y z qx qy qz qw id'; export it in this form: {}", path.string(),
                              line, words.size(), kHowToExport));
    }
    const std::vector<double> n = to_numbers(words, path, line);
    StampedPose pose{n[0], std::nullopt, to_matrix4({n[1], n[2], n[3]}, {n[7], n[4], n[5], n[6]})};
    if (n.size() > kColumns) pose.id = static_cast<std::int64_t>(n[kColumns]);
    poses.push_back(pose);
  });
  return poses;
}

// The files of an export: what comes before "rgb", and the poses.
struct ExportNames {
  std::string prefix;
  std::string poses;  // empty: there are none
  bool of_robot = false;
};

std::optional<ExportNames> names_of(const fs::path& folder) {
  constexpr std::string_view kCalibration = "calib";
  for (const std::string& name : names_in_folder(folder)) {
    if (!name.ends_with(kCalibration)) continue;
    ExportNames names{name.substr(0, name.size() - kCalibration.size()), "", false};
    if (!is_folder(folder / name) || !is_folder(folder / (names.prefix + "rgb")) || !is_folder(folder / (names.prefix + "depth")))
      continue;
    for (const std::string& file : {names.prefix + "camera_poses.txt", names.prefix + "poses.txt"}) {
      if (names.poses.empty() && is_there(folder / file)) names.poses = file;
    }
    if (files_in(folder, name, std::array<std::string_view, 1>{".yaml"}).empty()) continue;
    names.of_robot = !names.prefix.empty() && names.poses == names.prefix + "poses.txt";
    return names;
  }
  return std::nullopt;
}

std::string stem_of_frame(const FileFrame& frame) {
  return fs::path(frame.depth.empty() ? frame.color : frame.depth).stem().string();
}

// The frame's pose: that of its id, or of its stamp.
const StampedPose* pose_of_frame(const std::vector<StampedPose>& poses, const std::string& stem) {
  const std::optional<double> name = to_number(stem);
  if (!name) return nullptr;
  const bool is_stamp = stem.find('.') != std::string::npos;
  const auto found = std::find_if(poses.begin(), poses.end(), [&](const StampedPose& pose) {
    return is_stamp ? std::abs(pose.time_s - *name) <= kSameStamp_s : pose.id && static_cast<double>(*pose.id) == *name;
  });
  return found == poses.end() ? nullptr : &*found;
}

void give_calibrations(FileRecording& recording, const std::string& folder, std::vector<Eigen::Matrix4d>& robot_from_camera) {
  Calibration& calibration = recording.calibration;
  for (FileFrame& frame : recording.frames) {
    const std::string stem = (fs::path(folder) / stem_of_frame(frame)).string();
    robot_from_camera.emplace_back(Eigen::Matrix4d::Identity());
    if (is_there(recording.root / (stem + "_0.yaml")))
      throw Error(fmt::format("{}: images of several cameras beside each other are not read", recording.root.string()));
    try {
      if (!is_there(recording.root / (stem + ".yaml"))) throw Error(fmt::format("{}.yaml is missing", stem));
      const CalibrationFile file = read_calibration_file(recording.root / (stem + ".yaml"));
      if (calibration.depth.width == 0) {
        calibration.depth = file.camera;
        calibration.depth_distortion = file.distortion;
      }
      if (file.distortion != calibration.depth_distortion)
        throw Error(fmt::format("{}.yaml has another lens than the first", stem));
      frame.camera = file.camera;
      robot_from_camera.back() = file.robot_from_camera;
    } catch (const Error& e) {
      frame.problem = fmt::format("no intrinsics that can be used: {}", e.what());
    }
  }
  if (calibration.depth_distortion.empty()) return;
  // The maps that remove a distortion are made for one camera.
  bool differs = false;
  for (FileFrame& frame : recording.frames) {
    differs = differs || (frame.camera && *frame.camera != calibration.depth);
    frame.camera.reset();
  }
  if (differs) recording.assumed.emplace_back("all images have the intrinsics of the first, since the lens has a distortion");
}

void give_stamped_poses(FileRecording& recording, const ExportNames& names,
                        const std::vector<Eigen::Matrix4d>& robot_from_camera) {
  const std::vector<StampedPose> poses = read_poses(recording.root / names.poses);
  bool found = false;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    FileFrame& frame = recording.frames[i];
    const StampedPose* pose = pose_of_frame(poses, stem_of_frame(frame));
    if (pose == nullptr && frame.problem.empty()) frame.problem = fmt::format("no pose: {} has none of this image", names.poses);
    if (pose == nullptr) continue;
    found = true;
    frame.time_s = pose->time_s;
    frame.pose = names.of_robot ? Eigen::Matrix4d(pose->pose * robot_from_camera[i]) : pose->pose;
  }
  if (!found && !recording.frames.empty()) {
    throw Error(fmt::format("{}: none of its {} poses is of an image (the first is {}); export both with {}",
                            (recording.root / names.poses).string(), poses.size(), stem_of_frame(recording.frames.front()),
                            kHowToExport));
  }
  if (names.poses == "poses.txt")
    recording.assumed.emplace_back(
        "poses.txt holds the camera's poses, not the robot's: RTAB-Map asks which when it exports them");
}

}  // namespace

std::optional<FileRecording> recognise_rtabmap(const fs::path& folder, const PairingOptions& pairing) {
  const std::optional<ExportNames> names = names_of(folder);
  if (!names) return std::nullopt;
  FileRecording recording{"RTAB-Map export", folder, {}, {}};
  const std::vector<std::string> color = files_in(folder, names->prefix + "rgb", kColorEndings);
  require_color_images(folder, names->prefix + "rgb", color);
  add_frames_by_name(recording, {color, files_in(folder, names->prefix + "depth", kDepthEndings), {}});
  std::vector<Eigen::Matrix4d> robot_from_camera;
  give_calibrations(recording, names->prefix + "calib", robot_from_camera);
  if (pairing.without_poses) return recording;
  if (names->poses.empty()) {
    throw NoPoses(fmt::format("{}: RTAB-Map export without poses; export them ({}), or let panoptic run --track find them",
                              folder.string(), kHowToExport));
  }
  give_stamped_poses(recording, *names, robot_from_camera);
  return recording;
}

}  // namespace panoptic
