// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "panoptic/base/config.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr double kMaxFocal_px = 1e6;
constexpr double kMaxSide_px = 65536;
constexpr double kShapeTolerance = 0.02;
constexpr double kMinScale = 1e-6;
constexpr double kMaxScale = 1e9;
constexpr double kRotationTolerance = 1e-2;  // hand-written matrices carry few digits

Fields camera_fields(Camera& camera) {
  return {
      {"fx", &camera.fx, "focal length, pixels", in_range(1e-3, kMaxFocal_px)},
      {"fy", &camera.fy, "focal length, pixels", in_range(1e-3, kMaxFocal_px)},
      {"cx", &camera.cx, "principal point, pixels; the centre of the first pixel is 0", in_range(-kMaxSide_px, kMaxSide_px)},
      {"cy", &camera.cy, "principal point, pixels", in_range(-kMaxSide_px, kMaxSide_px)},
      {"width", &camera.width, "size of the images that the intrinsics belong to", in_range(1, kMaxSide_px)},
      {"height", &camera.height, "size of the images that the intrinsics belong to", in_range(1, kMaxSide_px)},
  };
}

bool known(const Camera& camera) { return camera.fx > 0; }

// A camera and its lens as a file gives them: NaN and nothing where it does not. The size of other intrinsics says nothing about
// new ones, and neither does their lens.
struct ReadCamera {
  static constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  Camera camera{0, 0, kMissing, kMissing, kMissing, kMissing};
  std::string model;
  Distortion distortion;

  bool has_lens() const { return !model.empty() || !distortion.empty(); }
  bool has_camera() const {
    return camera.width > 0 || camera.height > 0 || !std::isnan(camera.fx) || !std::isnan(camera.fy) || !std::isnan(camera.cx) ||
           !std::isnan(camera.cy);
  }
};

Fields read_fields(ReadCamera& read) {
  Fields fields = camera_fields(read.camera);
  fields.push_back({"distortion", &read.distortion, "of the lens: k1 k2 p1 p2, then k3, then k4 k5 k6", {}});
  fields.push_back({"distortion_model", &read.model, "opencv (plumb_bob, radtan, rational_polynomial) or none", {}});
  return fields;
}

// The numbers that the file gives, and those known before where it gives none.
Camera merged(Camera read, const Camera& before, std::string_view table, const std::string& path) {
  if ((read.width == 0) != (read.height == 0)) {
    throw Error(fmt::format("{}: [{}] has one of width and height: give both or neither", path, table));
  }
  constexpr std::array<double Camera::*, 4> kNumbers = {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy};
  const auto is_missing = [&](double Camera::*number) { return std::isnan(read.*number); };
  const auto missing = std::count_if(kNumbers.begin(), kNumbers.end(), is_missing);
  if (missing == 4 && read.width == 0) return before;
  if (missing > 0 && !known(before)) {
    throw Error(fmt::format("{}: [{}] needs fx, fy, cx and cy: the recording does not give them", path, table));
  }
  bool same = known(before);
  for (double Camera::*number : kNumbers) {
    if (is_missing(number)) read.*number = before.*number;
    same = same && read.*number == before.*number;
  }
  return same && read.width == 0 ? before : read;
}

Camera fitted(Camera camera, ImageSize size, std::string_view what, const std::string& source) {
  if (camera.width == 0) {
    camera.width = size.width;
    camera.height = size.height;
    return camera;
  }
  const double sx = static_cast<double>(size.width) / camera.width;
  const double sy = static_cast<double>(size.height) / camera.height;
  if (std::abs(sx / sy - 1) > kShapeTolerance) {
    throw Error(
        fmt::format("{}: the {} intrinsics are for {}x{} images but the images are {}x{}, which is another shape; give "
                    "the right ones with --calibration",
                    source, what, camera.width, camera.height, size.width, size.height));
  }
  return resized(camera, size.width, size.height);
}

std::shared_ptr<const LensMap> lens_of(const Camera& camera, const Distortion& distortion) {
  return distortion.empty() ? nullptr : std::make_shared<const LensMap>(lens_map(camera, distortion));
}

}  // namespace

Pose pose_of(const std::vector<double>& rotation, const std::vector<double>& translation, const std::string& place) {
  constexpr std::size_t kNine = 9;
  if (rotation.size() != kNine) {
    throw Error(fmt::format("{}rotation has {} numbers, expected 9 (row by row)", place, rotation.size()));
  }
  if (translation.size() != 3) {
    throw Error(fmt::format("{}translation has {} numbers, expected 3", place, translation.size()));
  }
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  pose.translation() = Eigen::Map<const Vec3d>(translation.data());
  if (!is_rigid(pose, kRotationTolerance)) {
    throw Error(fmt::format("{}rotation is not a rotation matrix (orthonormal, determinant 1)", place));
  }
  return rigid(pose.matrix());
}

void read_calibration(const std::filesystem::path& path, Calibration& calibration) {
  Calibration result = calibration;
  const Camera color_before = calibration.color.value_or(Camera{});
  ReadCamera depth;
  ReadCamera color;
  double scale = ReadCamera::kMissing;
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> known_rotation = calibration.color_from_depth.linear();
  const Vec3d known_translation = calibration.color_from_depth.translation();
  std::vector<double> rotation(known_rotation.data(), known_rotation.data() + known_rotation.size());
  std::vector<double> translation(known_translation.data(), known_translation.data() + known_translation.size());

  Fields fields;
  append_group(fields, "depth", read_fields(depth));
  append_group(fields, "color", read_fields(color));
  fields.push_back({"depth.scale", &scale, "raw value / scale = metres", in_range(kMinScale, kMaxScale)});
  fields.push_back({"depth.invalid", &result.invalid, "raw values that are no reading, besides 0", {}});
  fields.push_back({"color_from_depth.rotation", &rotation, "9 numbers, row by row", {}});
  fields.push_back({"color_from_depth.translation", &translation, "3 numbers, metres", {}});
  read_toml_file(path, fields);

  result.depth = merged(depth.camera, calibration.depth, "depth", path.string());
  const Camera color_camera = merged(color.camera, color_before, "color", path.string());
  if (known(color_camera)) result.color = color_camera;
  if (depth.has_camera() || depth.has_lens())
    result.depth_distortion = to_distortion(depth.model, depth.distortion, path.string() + ": [depth]");
  if (color.has_camera() || color.has_lens())
    result.color_distortion = to_distortion(color.model, color.distortion, path.string() + ": [color]");
  if (!std::isnan(scale)) result.depth_scale = scale;
  result.scale_is_assumed = result.scale_is_assumed && std::isnan(scale);
  result.camera_is_assumed = result.camera_is_assumed && !depth.has_camera();
  result.color_from_depth = pose_of(rotation, translation, path.string() + ": color_from_depth.");
  const bool color_moved = !result.color_from_depth.isApprox(calibration.color_from_depth);
  result.color_is_assumed = result.color_is_assumed && !color.has_camera() && !color_moved;
  calibration = result;
}

Calibration fitted(const Calibration& calibration, ImageSize depth, ImageSize color, const std::string& source) {
  if (!known(calibration.depth)) {
    throw Error(
        fmt::format("{}: no camera intrinsics found; give them with --calibration FILE.toml ([depth] fx fy cx cy)", source));
  }
  Calibration result = calibration;
  result.depth = fitted(calibration.depth, depth, "depth", source);
  result.color = calibration.color ? fitted(*calibration.color, color, "colour", source)
                                   : fitted(result.depth, color, "depth (used for colour too)", source);
  const Distortion of_color =
      calibration.color_distortion.value_or(calibration.color ? Distortion{} : calibration.depth_distortion);
  result.depth_lens = lens_of(result.depth, calibration.depth_distortion);
  result.color_lens = lens_of(*result.color, of_color);
  return result;
}

Calibration with_camera(Calibration calibration, const Camera& camera, const std::string& source) {
  const ImageSize depth{calibration.depth.width, calibration.depth.height};
  const ImageSize color{calibration.color->width, calibration.color->height};
  calibration.depth = fitted(camera, depth, "depth", source);
  calibration.color = fitted(camera, color, "colour", source);
  return calibration;
}

}  // namespace panoptic
