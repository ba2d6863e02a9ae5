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

// The camera that a file is read into: NaN where the file has to give a number because the recording does not; no size, since
// the size of other intrinsics says nothing about new ones.
Camera blank(const Camera& camera) {
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  return known(camera) ? Camera{0, 0, camera.fx, camera.fy, camera.cx, camera.cy}
                       : Camera{0, 0, kMissing, kMissing, kMissing, kMissing};
}

// The camera after the file was read over blank(before).
Camera merged(Camera read, const Camera& before, std::string_view table, const std::string& path) {
  if ((read.width == 0) != (read.height == 0)) {
    throw Error(fmt::format("{}: [{}] has one of width and height: give both or neither", path, table));
  }
  const std::array<double, 4> numbers = {read.fx, read.fy, read.cx, read.cy};
  const auto missing = std::count_if(numbers.begin(), numbers.end(), [](double x) { return std::isnan(x); });
  if (missing == 4 && read.width == 0) return before;
  if (missing > 0) {
    throw Error(fmt::format("{}: [{}] needs fx, fy, cx and cy: the recording does not give them", path, table));
  }
  const bool same = known(before) && numbers == std::array<double, 4>{before.fx, before.fy, before.cx, before.cy};
  if (same && read.width == 0) return before;
  return read;
}

Pose pose_of(const std::vector<double>& rotation, const std::vector<double>& translation, const std::string& path) {
  constexpr std::size_t kNine = 9;
  if (rotation.size() != kNine) {
    throw Error(fmt::format("{}: color_from_depth.rotation has {} numbers, expected 9 (row by row)", path, rotation.size()));
  }
  if (translation.size() != 3) {
    throw Error(fmt::format("{}: color_from_depth.translation has {} numbers, expected 3", path, translation.size()));
  }
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  pose.translation() = Eigen::Map<const Vec3d>(translation.data());
  if (!is_rigid(pose, kRotationTolerance)) {
    throw Error(fmt::format("{}: color_from_depth.rotation is not a rotation matrix (orthonormal, determinant 1)", path));
  }
  return rigid(pose.matrix());
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

}  // namespace

void read_calibration(const std::filesystem::path& path, Calibration& calibration) {
  Calibration result = calibration;
  const Camera color_before = calibration.color.value_or(Camera{});
  Camera depth = blank(calibration.depth);
  Camera color = blank(color_before);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> known_rotation = calibration.color_from_depth.linear();
  const Vec3d known_translation = calibration.color_from_depth.translation();
  std::vector<double> rotation(known_rotation.data(), known_rotation.data() + known_rotation.size());
  std::vector<double> translation(known_translation.data(), known_translation.data() + known_translation.size());

  Fields fields;
  append_group(fields, "depth", camera_fields(depth));
  append_group(fields, "color", camera_fields(color));
  double scale = std::numeric_limits<double>::quiet_NaN();
  fields.push_back({"depth.scale", &scale, "raw value / scale = metres", in_range(kMinScale, kMaxScale)});
  fields.push_back({"depth.invalid", &result.invalid, "raw values that are no reading, besides 0", {}});
  fields.push_back({"color_from_depth.rotation", &rotation, "9 numbers, row by row", {}});
  fields.push_back({"color_from_depth.translation", &translation, "3 numbers, metres", {}});
  read_toml_file(path, fields);

  result.depth = merged(depth, calibration.depth, "depth", path.string());
  color = merged(color, color_before, "color", path.string());
  if (known(color)) result.color = color;
  if (!std::isnan(scale)) result.depth_scale = scale;
  result.scale_is_assumed = result.scale_is_assumed && std::isnan(scale);
  result.color_from_depth = pose_of(rotation, translation, path.string());
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
  return result;
}

}  // namespace panoptic
