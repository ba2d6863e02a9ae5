// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/frame.h"

#include <algorithm>
#include <cmath>

namespace panoptic {
namespace {

bool valid_camera(const Camera& camera) {
  return camera.width > 0 && camera.height > 0 && std::isfinite(camera.fx) && std::isfinite(camera.fy) && camera.fx > 0 &&
         camera.fy > 0 && std::isfinite(camera.cx) && std::isfinite(camera.cy);
}

// No lens draws straight lines straight over more than that, and every other source of such intrinsics is a mistake (metres or
// shares of the image in place of pixels). So a surface that a frame sees has at most 56 times the square of its distance in
// area.
bool sees_too_much(const Camera& camera) {
  constexpr double kTangentOfHalf = 3.7320508;  // of 150 degrees
  const double x = std::max(std::abs(camera.cx), std::abs(camera.width - 1 - camera.cx)) / camera.fx;
  const double y = std::max(std::abs(camera.cy), std::abs(camera.height - 1 - camera.cy)) / camera.fy;
  return !(std::hypot(x, y) <= kTangentOfHalf);
}

bool has_reading(const ImageView<float>& depth) {
  const auto is_reading = [](float z) { return z > 0 && std::isfinite(z); };
  bool any = false;
  for (int v = 0; v < depth.height() && !any; ++v) any = std::any_of(depth.row(v), depth.row(v) + depth.width(), is_reading);
  return any;
}

bool has_sound_weights(const Frame& frame) {
  for (int v = 0; v < frame.depth.height(); ++v) {
    const float* depth = frame.depth.row(v);
    const float* weight = frame.depth_weight.row(v);
    for (int u = 0; u < frame.depth.width(); ++u) {
      if (depth[u] > 0 && !(weight[u] > 0 && weight[u] <= 1)) return false;
    }
  }
  return true;
}

}  // namespace

Frame kept(Frame frame) {
  frame.depth = frame.depth.kept();
  frame.depth_weight = frame.depth_weight.kept();
  frame.color = frame.color.kept();
  return frame;
}

Outcome check(const Frame& frame) {
  if (!is_finite(frame.world_from_camera)) return Outcome::refused("pose is not finite");
  if (!is_rigid(frame.world_from_camera)) return Outcome::refused("pose is not a rigid transform");
  if (!valid_camera(frame.depth_camera)) return Outcome::refused("depth camera has no valid intrinsics");
  if (!valid_camera(frame.color_camera)) return Outcome::refused("colour camera has no valid intrinsics");
  if (sees_too_much(frame.depth_camera))
    return Outcome::refused("depth camera would see more than 150 degrees; are its intrinsics in pixels?");
  if (sees_too_much(frame.color_camera))
    return Outcome::refused("colour camera would see more than 150 degrees; are its intrinsics in pixels?");
  if (frame.depth.empty()) return Outcome::refused("depth image is missing");
  if (frame.color.empty()) return Outcome::refused("colour image is missing");
  if (!frame.depth.same_size(frame.depth_camera.width, frame.depth_camera.height))
    return Outcome::refused("depth image has the wrong size");
  if (!frame.color.same_size(frame.color_camera.width, frame.color_camera.height))
    return Outcome::refused("colour image has the wrong size");
  if (!is_rigid(frame.color_from_depth)) return Outcome::refused("colour camera pose is not a rigid transform");
  if (!has_reading(frame.depth)) return Outcome::refused("depth image has no reading");
  if (frame.depth_weight.empty()) return {};
  if (!frame.depth_weight.same_size(frame.depth.width(), frame.depth.height()))
    return Outcome::refused("image of depth weights has another size than the depth image");
  return has_sound_weights(frame) ? Outcome{} : Outcome::refused("a depth weight is not above 0 and at most 1");
}

}  // namespace panoptic
