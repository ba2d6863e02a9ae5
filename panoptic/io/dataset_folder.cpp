// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The plain folder: what somebody writes who has images, poses and a camera matrix and wants no format.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_formats.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

// The last number in a file name, whatever stands around it. Names that are time stamps ("1305031102.175304") count in
// nanoseconds. Nothing without digits or with more than fit.
std::optional<std::int64_t> number_in_stem(std::string_view stem) {
  constexpr std::string_view kDigits = "0123456789";
  constexpr std::size_t kNanoDigits = 9;
  const std::size_t last = stem.find_last_of(kDigits);
  if (last == std::string_view::npos) return std::nullopt;
  std::string_view number = stem.substr(0, last + 1);
  std::string digits;
  const std::size_t begin = number.find_last_not_of("0123456789.");
  number.remove_prefix(begin == std::string_view::npos ? 0 : begin + 1);
  const std::size_t point = number.find('.');
  digits = number.substr(0, point);
  if (point != std::string_view::npos) {
    std::string fraction(number.substr(point + 1));
    fraction.resize(kNanoDigits, '0');
    digits += fraction;
  }
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return error == std::errc{} && end == digits.data() + digits.size() ? std::optional(value) : std::nullopt;
}

NumberedFiles list_files(const fs::path& root, const std::string& folder, std::span<const std::string_view> extensions) {
  NumberedFiles files;
  for (const fs::path name : names_in_folder(root / folder)) {
    if (std::find(extensions.begin(), extensions.end(), name.extension().string()) == extensions.end()) continue;
    const auto number = number_in_stem(name.stem().string());
    if (!number) continue;
    const auto [at, added] = files.emplace(*number, (fs::path(folder) / name).string());
    if (!added) {
      throw Error(fmt::format("{}: {} and {} have the same number; rename one", (root / folder).string(),
                              fs::path(at->second).filename().string(), name.string()));
    }
  }
  return files;
}

std::optional<std::string> first_folder(const fs::path& root, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (is_folder(root / name)) return name;
  }
  return std::nullopt;
}

// poses.txt holds one line for each colour image in numeric order; which line belongs to which image is only sure if the
// counts are the same.
void assign_poses(std::vector<FileFrame>& frames, const fs::path& path) {
  const std::vector<Eigen::Matrix4d> poses = read_matrix_lines(path);
  const auto images = static_cast<std::size_t>(
      std::count_if(frames.begin(), frames.end(), [](const FileFrame& frame) { return !frame.color.empty(); }));
  if (poses.size() != images) {
    throw Error(fmt::format("{}: {} poses for {} colour images; expected one line for each image, in the order of their names",
                            path.string(), poses.size(), images));
  }
  std::size_t line = 0;
  for (FileFrame& frame : frames) {
    if (!frame.color.empty()) frame.pose = poses[line++];
  }
}

}  // namespace

std::optional<FileRecording> recognise_plain_folder(const fs::path& folder) {
  constexpr std::array<std::string_view, 3> kColor = {".png", ".jpg", ".jpeg"};
  constexpr std::array<std::string_view, 4> kDepth = {".png", ".pgm", ".tiff", ".tif"};
  constexpr std::array<std::string_view, 1> kPose = {".txt"};
  const auto images = first_folder(folder, {"images", "color", "rgb"});
  const auto poses = first_folder(folder, {"poses", "pose"});
  const bool has_pose_file = is_there(folder / "poses.txt");
  if (!images || !is_folder(folder / "depth") || (!poses && !has_pose_file)) return std::nullopt;
  FileRecording recording{"plain folder", folder, {}, {}};
  if (is_there(folder / "K.txt")) recording.calibration.depth = read_camera_matrix(folder / "K.txt");
  const NumberedFiles depth = list_files(folder, "depth", kDepth);
  const bool in_metres = !depth.empty() && fs::path(depth.begin()->second).extension().string().starts_with(".tif");
  if (in_metres) recording.calibration.depth_scale = 1;
  recording.frames =
      joined(list_files(folder, *images, kColor), depth, poses ? list_files(folder, *poses, kPose) : NumberedFiles{});
  if (has_pose_file) assign_poses(recording.frames, folder / "poses.txt");
  return recording;
}

}  // namespace panoptic
