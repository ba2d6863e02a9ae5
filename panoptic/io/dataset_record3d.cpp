// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The export "EXR + RGB" of the app Record3D (https://github.com/marek-simonik/record3d): the folder EXR_RGBD with rgb/N.jpg,
// depth/N.exr in metres and metadata.json. Its author in issues 27, 31, 33, 67 and 108 there: a pose is qx qy qz qw px py pz, of
// a camera with OpenGL's axes (x right, y up, looking along -z) in the world; K belongs to the images of colour, to which depth
// is registered, and lists its columns one after the other.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/base/json_value.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_list.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.json";
constexpr double kMaxSide_px = 65536;

// The numbers of an array; null, which stands for what cannot be written in JSON, becomes NaN.
std::vector<double> numbers_of(const JsonValue& array) {
  constexpr double kLargest = 1e12;
  std::vector<double> numbers;
  for (const JsonValue& value : array.elements())
    numbers.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.number(-kLargest, kLargest));
  return numbers;
}

Eigen::Matrix4d to_pose_matrix(const JsonValue& array) {
  constexpr std::size_t kNumbers = 7;
  const std::vector<double> n = numbers_of(array);
  if (n.size() != kNumbers) array.wrong("7 numbers: qx qy qz qw px py pz");
  const Eigen::Matrix4d opencv_axes = Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
  return to_matrix4({n[4], n[5], n[6]}, {n[3], n[0], n[1], n[2]}) * opencv_axes;
}

Camera sized(Camera camera, const JsonValue& metadata) {
  camera.width = static_cast<int>(metadata.at("w").integer(1, static_cast<std::int64_t>(kMaxSide_px)));
  camera.height = static_cast<int>(metadata.at("h").integer(1, static_cast<std::int64_t>(kMaxSide_px)));
  return camera;
}

void give_cameras(FileRecording& recording, const JsonValue& metadata, const std::string& path) {
  recording.calibration.depth = sized(to_camera(numbers_of(metadata.at("K")), path + ": K"), metadata);
  const auto own = metadata.find("perFrameIntrinsicCoeffs");
  if (!own || own->is_null()) return;
  const std::vector<JsonValue> rows = own->elements();
  for (FileFrame& frame : recording.frames) {
    const auto number = static_cast<std::size_t>(frame.number);
    if (number >= rows.size()) continue;
    try {
      frame.camera = sized(to_camera(numbers_of(rows[number]), path + ": perFrameIntrinsicCoeffs"), metadata);
    } catch (const Error& e) {
      frame.problem = fmt::format("no intrinsics that can be used: {}", e.what());
    }
  }
}

void give_times_and_poses(FileRecording& recording, const JsonValue& metadata) {
  constexpr double kMostPerSecond = 1e4;
  constexpr double kAssumedRate_hz = 60;
  const std::vector<JsonValue> poses = metadata.at("poses").elements();
  const auto rate = metadata.find("fps");
  const double rate_hz = rate ? rate->number(1 / kMostPerSecond, kMostPerSecond) : kAssumedRate_hz;
  const auto listed = metadata.find("frameTimestamps");
  const std::vector<double> times_s = listed && !listed->is_null() ? numbers_of(*listed) : std::vector<double>{};
  for (FileFrame& frame : recording.frames) {
    const auto number = static_cast<std::size_t>(frame.number);
    const bool is_timed = number < times_s.size() && std::isfinite(times_s[number]);
    frame.time_s = is_timed ? times_s[number] : static_cast<double>(number) / rate_hz;
    if (number < poses.size()) frame.pose = to_pose_matrix(poses[number]);
    if (number >= poses.size()) frame.problem = fmt::format("no pose: {} has {}", kMetadata, poses.size());
  }
}

void give_confidence(FileRecording& recording, const fs::path& root) {
  constexpr std::array<std::string_view, 1> kPng = {".png"};
  const NumberedFiles files = numbered_files(root, "confidence", "", kPng);
  recording.has_confidence = !files.empty();
  for (FileFrame& frame : recording.frames) {
    const auto file = files.find(frame.number);
    if (file != files.end()) frame.confidence = file->second;
  }
  if (files.empty())
    recording.assumed.emplace_back("every depth reading is as sure as others: there are no images in confidence/");
}

}  // namespace

std::optional<FileRecording> recognise_record3d(const fs::path& folder) {
  const fs::path root = is_there(folder / "EXR_RGBD" / kMetadata) ? folder / "EXR_RGBD" : folder;
  const bool has_parts = is_there(root / kMetadata) && is_folder(root / "rgb") && is_folder(root / "depth");
  if (!has_parts || pose_file_in(root)) return std::nullopt;  // with a list of poses it is somebody else's
  const std::string path = (root / kMetadata).string();
  const Json json = read_json_file(root / kMetadata);
  const JsonValue metadata(json, path);
  FileRecording recording{"Record3D", root, {}, {}};
  recording.frames = joined(numbered_files(root, "rgb", "", kColorEndings), numbered_files(root, "depth", "", kDepthEndings), {});
  if (recording.frames.empty())
    throw Error(fmt::format("{}: no images called rgb/0.jpg and depth/0.exr in it; export it as EXR + RGB again", root.string()));
  const bool is_float = !files_in(root, "depth", std::array<std::string_view, 1>{".exr"}).empty();
  recording.calibration.depth_scale = is_float ? 1 : recording.calibration.depth_scale;
  give_times_and_poses(recording, metadata);
  give_cameras(recording, metadata, path);
  give_confidence(recording, root);
  return recording;
}

}  // namespace panoptic
