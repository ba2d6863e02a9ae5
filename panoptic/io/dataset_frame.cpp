// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/dataset_frame.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <string_view>
#include <utility>

namespace panoptic {
namespace {

constexpr double kRotationTolerance = 0.05;

template <typename T>
Outcome check_size(const Image<T>& image, const Camera& camera, std::string_view what) {
  if (image.same_size(camera.width, camera.height)) return {};
  return Outcome::refused(
      fmt::format("{} is {}x{}, expected {}x{}", what, image.width(), image.height(), camera.width, camera.height));
}

bool is_invalid(double raw, const std::vector<double>& invalid) {
  return !(raw > 0) || std::find(invalid.begin(), invalid.end(), raw) != invalid.end();
}

}  // namespace

ReadResult skipped(std::int64_t number, std::string reason) { return {std::nullopt, {number, std::move(reason)}}; }

Outcome check_pose(const Eigen::Matrix4d& pose) {
  if (!pose.allFinite()) return Outcome::refused("pose is not finite");
  const Eigen::Matrix3d linear = pose.topLeftCorner<3, 3>();
  const Vec3d stretch = Eigen::JacobiSVD<Eigen::Matrix3d>(linear).singularValues();
  const double last_row = (pose.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff();
  const bool near_rotation = (stretch.array() - 1).abs().maxCoeff() <= kRotationTolerance && linear.determinant() > 0;
  if (!near_rotation || last_row > kRotationTolerance) return Outcome::refused("pose is not a rigid transform");
  return {};
}

Image<float> to_metres(const Image<std::uint16_t>& raw, const Calibration& calibration) {
  Image<float> depth(raw.width(), raw.height());
  const auto metres_per_unit = static_cast<float>(1 / calibration.depth_scale);
  for (std::size_t i = 0; i < raw.size(); ++i) {
    depth[i] = is_invalid(raw[i], calibration.invalid) ? 0.0F : static_cast<float>(raw[i]) * metres_per_unit;
  }
  return depth;
}

Image<float> to_metres(Image<float> raw, const Calibration& calibration) {
  const auto metres_per_unit = static_cast<float>(1 / calibration.depth_scale);
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const float value = raw[i];
    raw[i] = is_invalid(value, calibration.invalid) || !std::isfinite(value) ? 0.0F : value * metres_per_unit;
  }
  return raw;
}

Pose camera_pose(const Eigen::Matrix4d& pose, const Calibration& calibration) {
  return rigid(pose) * calibration.posed_from_depth;
}

ReadResult finish(RawFrame raw, const Calibration& calibration) {
  const Camera color_camera = calibration.color.value_or(calibration.depth);
  for (const Outcome& outcome : {check_pose(raw.pose), check_size(raw.depth, calibration.depth, "depth image"),
                                 check_size(raw.color, color_camera, "colour image")}) {
    if (!outcome.used) return skipped(raw.number, outcome.reason);
  }
  Frame frame;
  frame.index = raw.number;
  frame.time_s = raw.time_s;
  frame.depth_camera = calibration.depth;
  frame.color_camera = color_camera;
  frame.color_from_depth = calibration.color_from_depth;
  frame.world_from_camera = camera_pose(raw.pose, calibration);
  frame.depth = calibration.depth_lens ? undistorted(raw.depth, *calibration.depth_lens) : std::move(raw.depth);
  frame.depth_weight = calibration.depth_lens && !raw.depth_weight.empty()
                           ? undistorted(raw.depth_weight, *calibration.depth_lens)
                           : std::move(raw.depth_weight);
  frame.color = calibration.color_lens ? undistorted(raw.color, *calibration.color_lens) : std::move(raw.color);
  return {std::move(frame), {}};
}

}  // namespace panoptic
