// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/camera_file.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/base/text.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_text.h"
#include "panoptic/io/image_names.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

// All numbers below a value, in order: a matrix as one list or as a list of rows.
void flatten(const Json& value, std::vector<double>& numbers) {
  constexpr std::size_t kMost = 16;
  if (value.is_number() && numbers.size() <= kMost) numbers.push_back(value.get<double>());
  if (!value.is_array()) return;
  for (const Json& part : value) flatten(part, numbers);
}

std::optional<double> number_of(const Json& object, std::span<const std::string_view> keys) {
  for (const std::string_view key : keys) {
    const auto found = object.find(key);
    if (found != object.end() && found->is_number()) return found->get<double>();
  }
  return std::nullopt;
}

std::optional<Camera> camera_of(const Json& object, const std::string& path) {
  constexpr std::array<std::string_view, 6> kMatrices = {"intrinsic_matrix", "camera_matrix", "K", "cam_K", "intrinsics", "data"};
  for (const std::string_view key : kMatrices) {
    const auto found = object.find(key);
    if (found == object.end()) continue;
    if (found->is_object()) return camera_of(*found, path);
    std::vector<double> numbers;
    flatten(*found, numbers);
    return to_camera(numbers, path);
  }
  constexpr std::array<std::string_view, 3> kFx = {"fx", "fl_x", "focal_x"};
  constexpr std::array<std::string_view, 3> kFy = {"fy", "fl_y", "focal_y"};
  constexpr std::array<std::string_view, 2> kCx = {"cx", "ppx"};
  constexpr std::array<std::string_view, 2> kCy = {"cy", "ppy"};
  const auto fx = number_of(object, kFx);
  const auto fy = number_of(object, kFy);
  const auto cx = number_of(object, kCx);
  const auto cy = number_of(object, kCy);
  if (!fx || !fy || !cx || !cy) return std::nullopt;
  return to_camera(std::array{*fx, *fy, *cx, *cy}, path);
}

int side_of(const Json& object, std::span<const std::string_view> keys, const std::string& path) {
  constexpr double kMaxSide_px = 65536;
  const double side = number_of(object, keys).value_or(0);
  if (!(side >= 0) || side > kMaxSide_px) throw Error(fmt::format("{}: {} is no image size", path, side));
  return static_cast<int>(side);
}

void read_camera_json(const fs::path& path, Calibration& calibration) {
  constexpr std::array<std::string_view, 3> kWidth = {"width", "w", "image_width"};
  constexpr std::array<std::string_view, 3> kHeight = {"height", "h", "image_height"};
  constexpr std::array<std::string_view, 2> kScale = {"depth_scale", "scale"};
  constexpr double kMaxScale = 1e9;
  const Json json = read_json_file(path);
  const bool nested = json.is_object() && json.contains("camera") && json["camera"].is_object();
  const Json& object = nested ? json["camera"] : json;
  const auto camera = object.is_object() ? camera_of(object, path.string()) : std::nullopt;
  if (!camera)
    throw Error(fmt::format("{}: no intrinsics; expected \"intrinsic_matrix\" or \"fx\", \"fy\", \"cx\", \"cy\"", path.string()));
  calibration.depth = *camera;
  calibration.depth.width = side_of(object, kWidth, path.string());
  calibration.depth.height = side_of(object, kHeight, path.string());
  if (calibration.depth.width == 0 || calibration.depth.height == 0) calibration.depth.width = calibration.depth.height = 0;
  const auto scale = number_of(object, kScale);
  if (!scale) return;
  if (!(*scale > 1 / kMaxScale) || *scale > kMaxScale)
    throw Error(fmt::format("{}: the depth scale {} is out of range", path.string(), *scale));
  calibration.depth_scale = *scale < 1 ? 1 / *scale : *scale;  // RealSense's is metres of a unit, .001
  calibration.scale_is_assumed = false;
}

}  // namespace

std::optional<std::string> first_named(const fs::path& folder, std::span<const std::string_view> names,
                                       const std::function<bool(const std::string& name)>& counts) {
  const std::vector<std::string> present = names_in_folder(folder);
  for (const std::string_view name : names) {
    for (const std::string& there : present) {
      if (lower_case(there) == name && (!counts || counts(there))) return there;
    }
  }
  return std::nullopt;
}

std::optional<std::string> camera_file_in(const fs::path& folder) {
  constexpr std::array<std::string_view, 18> kNames = {"k.txt",
                                                       "intrinsic.txt",
                                                       "intrinsics.txt",
                                                       "intrinsic_depth.txt",
                                                       "intrinsics_depth.txt",
                                                       "cam_k.txt",
                                                       "camera_intrinsic.json",
                                                       "camera_intrinsics.json",
                                                       "intrinsic.json",
                                                       "intrinsics.json",
                                                       "camera.json",
                                                       "cam_params.json",
                                                       "calibration.txt",
                                                       "calib.txt",
                                                       "camera-intrinsics.txt",
                                                       "k_depth.txt",
                                                       "camera_intrinsics.txt",
                                                       "camera.txt"};
  return first_named(folder, kNames);
}

void read_camera_file(const fs::path& path, Calibration& calibration) {
  if (ending_of(path) == ".json") return read_camera_json(path, calibration);
  calibration.depth = read_camera_matrix(path);
}

}  // namespace panoptic
