// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses for recordings that have none: where the camera is, from the map that the frames before have made. A tracker is asked for
// the pose of a frame (track), the frame is added to a Mapper with it, and the tracker is told so (keep); where the camera is
// lost, the frame must not be added. When the camera comes back to a place, the poses since then are corrected: see
// corrected_poses and Mapper::update_poses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

enum class TrackingState : std::uint8_t { kBegun, kTracked, kFoundAgain, kLost };
std::string_view to_text(TrackingState state);  // "begun", "tracked", "found again", "lost"

struct CameraPose {
  TrackingState state = TrackingState::kLost;
  Pose world_from_camera = Pose::Identity();  // meaningless if lost
  std::string reason;                         // why it is lost, for a person
  // From 0 to 1: the share of the frame's readings near surface of the map that lie on it as well as the sensor can tell.
  double quality = 0;
  // The covariance of the motion of the camera in its own frame by which the pose may be off: translation (m^2), then rotation
  // (rad^2).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();

  bool is_known() const { return state != TrackingState::kLost; }
};

// A place that was recognised.
struct Loop {
  std::int64_t frame = 0;
  std::int64_t earlier_frame = 0;
  Pose earlier_from_frame = Pose::Identity();  // as measured between the two
  double moved_m = 0;                          // how far the pose of `frame` was off by it
  bool is_believed = true;                     // false: the camera cannot have drifted so far; nothing comes of it
  bool corrects = false;                       // false: the poses fitted already, or it is not believed
};

struct FramePose {
  std::int64_t frame = 0;
  double time_s = 0;
  Pose world_from_camera = Pose::Identity();
};

struct CameraTrackerOptions {
  // Readings outside [min, max] count as missing, as DepthOptions.
  float min_depth_m = 0.1F;
  float max_depth_m = 8;
  // The pose of the first frame. Unless it is given, the camera starts level at the origin: it looks along the world's y axis, z
  // is up.
  std::optional<Pose> start;
};

// The poses of a path at which a tracker that follows it makes keyframes, as far as poses alone tell: positions, ascending.
std::vector<std::size_t> keyframes_along(const std::vector<Pose>& path);

// One thread at a time; it works on several itself, and its poses are the same for any number of them (on one machine: Ceres and
// OpenCV may differ between CPUs). Its memory grows with the number of keyframes and a pose for each frame.
class CameraTracker {
 public:
  // Throws Error for options that are out of range.
  explicit CameraTracker(const CameraTrackerOptions& options = {});
  ~CameraTracker();
  CameraTracker(CameraTracker&&) noexcept;
  CameraTracker& operator=(CameraTracker&&) noexcept;
  CameraTracker(const CameraTracker&) = delete;
  CameraTracker& operator=(const CameraTracker&) = delete;

  // A frame of an earlier visit of the place, with its pose in the world of the map, by which the place may be recognised. The
  // camera is lost then until it is found at such a place, and the poses of these frames stay as they are. keyframes_along says
  // which frames are worth it. REQUIRES that `check` takes the frame, and that none was tracked before.
  void remember(const Frame& frame);

  // The pose of the next frame (its own is not looked at) in the map of all frames before it. A frame that `check` refuses is
  // lost, with that reason.
  CameraPose track(const Frame& frame, const VoxelMap& map);
  // The frame that was tracked last is in the map, with that pose. Without it the frame is forgotten. Here keyframes are made and
  // loops are looked for. REQUIRES that its pose was known.
  void keep(const Frame& frame);

  // The poses of all frames that were tracked, if a loop changed them since the last call. The tracker goes on from these: the
  // map must follow (Mapper::update_poses) before the next frame is tracked.
  std::optional<std::vector<FramePose>> corrected_poses();

  std::vector<FramePose> trajectory() const;
  const std::vector<Loop>& loops() const;
  std::size_t keyframes() const;  // those that were remembered included

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace panoptic
