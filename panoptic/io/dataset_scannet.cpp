// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The two exporters that come with ScanNet.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/camera_file.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/dataset_frame.h"
#include "panoptic/io/image_names.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

// The exporter can shrink the images while the intrinsic files keep the values of the sensor's size, which is written nowhere.
// The principal point lies near the middle of the image that it belongs to: that tells which of the sensor sizes it is.
void name_sensor_size(Camera& camera) {
  constexpr std::array<ImageSize, 2> kSensorSizes = {{{1296, 968}, {640, 480}}};
  constexpr double kTolerance = 0.1;
  for (const ImageSize size : kSensorSizes) {
    const bool near_middle = std::abs((2 * camera.cx + 1) / size.width - 1) < kTolerance &&
                             std::abs((2 * camera.cy + 1) / size.height - 1) < kTolerance;
    if (!near_middle) continue;
    camera.width = size.width;
    camera.height = size.height;
    return;
  }
}

Pose to_extrinsic(std::span<const double> numbers, const std::string& source) {
  const auto matrix = to_matrix(numbers);
  if (!matrix) throw Error(fmt::format("{}: {} numbers, expected a 4x4 matrix", source, numbers.size()));
  if (const Outcome pose = check_pose(*matrix); !pose.used) throw Error(fmt::format("{}: {}", source, pose.reason));
  return rigid(*matrix);
}

void place_cameras(Calibration& calibration, const Pose& common_from_color, const Pose& common_from_depth) {
  calibration.posed_from_depth = common_from_depth;
  calibration.color_from_depth = common_from_color.inverse() * common_from_depth;
}

// intrinsic/intrinsic_depth.txt of the exporter, intrinsics_depth.txt of the subset of 25,000 frames.
std::optional<fs::path> intrinsic_file(const fs::path& root, const char* kind) {
  for (const char* form : {"intrinsic/intrinsic_{}.txt", "intrinsics_{}.txt", "intrinsic_{}.txt"}) {
    const fs::path path = root / fmt::format(fmt::runtime(form), kind);
    if (is_there(path)) return path;
  }
  return std::nullopt;
}

Camera sensor_camera(const fs::path& path) {
  Camera camera = read_camera_matrix(path);
  name_sensor_size(camera);
  return camera;
}

Calibration python_calibration(const fs::path& root) {
  Calibration calibration;
  const auto depth = intrinsic_file(root, "depth");
  if (!depth) {
    if (is_there(root / "intrinsic.txt")) calibration.depth = sensor_camera(root / "intrinsic.txt");
    return calibration;
  }
  calibration.depth = sensor_camera(*depth);
  if (const auto color = intrinsic_file(root, "color")) calibration.color = sensor_camera(*color);
  const auto extrinsic = [&](const char* name) {
    const fs::path path = root / "intrinsic" / name;
    return is_there(path) ? to_extrinsic(read_numbers(path), path.string()) : Pose::Identity();
  };
  place_cameras(calibration, extrinsic("extrinsic_color.txt"), extrinsic("extrinsic_depth.txt"));
  return calibration;
}

// "key = value words" of _info.txt.
std::map<std::string, std::vector<std::string>> read_info(const fs::path& path) {
  std::map<std::string, std::vector<std::string>> info;
  for_each_line(path, [&](std::size_t, std::span<const std::string_view> words) {
    if (words.size() > 2 && words[1] == "=") info[std::string(words[0])] = {words.begin() + 2, words.end()};
  });
  return info;
}

class InfoFile {
 public:
  explicit InfoFile(const fs::path& path) : path_(path.string()), values_(read_info(path)) {}

  std::vector<double> numbers(const std::string& key, std::size_t count) const {
    const auto found = values_.find(key);
    if (found == values_.end()) throw Error(fmt::format("{}: the key '{}' is missing", path_, key));
    const std::vector<std::string_view> words(found->second.begin(), found->second.end());
    std::vector<double> numbers;
    for (const std::string_view word : words) {
      const std::optional<double> number = to_number(word);
      if (!number) throw Error(fmt::format("{}: '{}' holds '{}', which is no number", path_, key, word));
      numbers.push_back(*number);
    }
    if (numbers.size() != count)
      throw Error(fmt::format("{}: '{}' has {} numbers, expected {}", path_, key, numbers.size(), count));
    return numbers;
  }
  Camera camera(const std::string& kind) const {
    Camera camera = to_camera(numbers("m_calibration" + kind + "Intrinsic", 16), path_);
    camera.width = whole("m_" + lower(kind) + "Width");
    camera.height = whole("m_" + lower(kind) + "Height");
    return camera;
  }
  Pose extrinsic(const std::string& kind) const {
    return to_extrinsic(numbers("m_calibration" + kind + "Extrinsic", 16), path_ + ": m_calibration" + kind + "Extrinsic");
  }
  double positive(const std::string& key) const {
    const double value = numbers(key, 1).front();
    if (!(value > 0) || !std::isfinite(value))
      throw Error(fmt::format("{}: '{}' is {}, expected a positive number", path_, key, value));
    return value;
  }

 private:
  static std::string lower(std::string kind) {
    kind.front() = static_cast<char>(kind.front() - 'A' + 'a');
    return kind;
  }
  int whole(const std::string& key) const {
    constexpr double kMaxSide_px = 65536;
    const double value = positive(key);
    if (value > kMaxSide_px || value != std::floor(value))
      throw Error(fmt::format("{}: '{}' is {}, not an image size", path_, key, value));
    return static_cast<int>(value);
  }

  std::string path_;
  std::map<std::string, std::vector<std::string>> values_;
};

}  // namespace

std::optional<FileRecording> recognise_scannet_export(const fs::path& folder) {
  const fs::path root = is_folder(folder / "frames" / "color") ? folder / "frames" : folder;
  const std::string poses = is_folder(root / "pose") ? "pose" : "poses";
  if (!is_folder(root / "color") || !is_folder(root / "depth") || !is_folder(root / poses)) return std::nullopt;
  const bool has_own = intrinsic_file(root, "depth") || is_there(root / "intrinsic.txt");
  if (!has_own && camera_file_in(root)) return std::nullopt;  // somebody else's
  FileRecording recording{"ScanNet export", root, {}, python_calibration(root)};
  add_frames_by_name(recording, {files_in(root, "color", kColorEndings), files_in(root, "depth", kDepthEndings),
                                 files_in(root, poses, kPoseEndings)});
  return recording;
}

std::optional<FileRecording> recognise_scannet_cpp_export(const fs::path& folder) {
  constexpr std::array<std::string_view, 2> kColor = {".color.jpg", ".color.png"};
  constexpr std::array<std::string_view, 2> kDepth = {".depth.pgm", ".depth.png"};
  constexpr std::array<std::string_view, 1> kPose = {".pose.txt"};
  // BundleFusion's authors used the same library (niessner/mLib) and another name.
  const bool is_bundle_fusion = !is_there(folder / "_info.txt");
  const fs::path info_file = folder / (is_bundle_fusion ? "info.txt" : "_info.txt");
  if (!is_there(info_file)) return std::nullopt;
  const NumberedFiles depth = numbered_files(folder, "", "frame-", kDepth);
  if (depth.empty()) return std::nullopt;
  const InfoFile info(info_file);
  FileRecording recording{is_bundle_fusion ? "BundleFusion" : "ScanNet C++ export", folder, {}, {}};
  recording.calibration.depth = info.camera("Depth");
  recording.calibration.color = info.camera("Color");
  recording.calibration.depth_scale = info.positive("m_depthShift");
  place_cameras(recording.calibration, info.extrinsic("Color"), info.extrinsic("Depth"));
  recording.frames = joined(numbered_files(folder, "", "frame-", kColor), depth, numbered_files(folder, "", "frame-", kPose));
  return recording;
}

}  // namespace panoptic
