// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses that change after their frames were mapped, as every SLAM system changes them when it closes a loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/source.h"

namespace panoptic {

// The corrected pose of a frame.
struct PoseUpdate {
  std::int64_t frame = 0;                     // Frame::index
  Pose world_from_camera = Pose::Identity();  // the depth camera
};

// Reads a frame of the recording once more, by its number. Its pose does not matter. One call at a time, from any thread.
using ReadFrame = std::function<ReadResult(std::int64_t frame)>;

// The outcome of a correction of poses.
struct Correction {
  std::size_t frames = 0;          // whose pose changed by more than map.pose_tolerance_m
  std::size_t unknown = 0;         // updates of frames that are not in the map; nothing comes of them
  std::int64_t first_unknown = 0;  // meaningful if there are any
  std::size_t blocks = 0;          // of the map afterwards
  std::size_t blocks_refused = 0;  // of those, fused anew
  double ms = 0;                   // all of it
  double wait_ms = 0;              // of that, waiting for frames to be read
  double pause_ms = 0;             // of it, when nobody could look at the map: online while the maps changed places, else all
};

// The corrections of a run at a moment: after the frame of this number, or after the last one before the end.
struct PoseUpdates {
  std::int64_t at_frame = 0;
  std::vector<PoseUpdate> poses;
};

// Reads corrections as any SLAM system can write them: a line of JSON for each moment,
// {"at_frame": 120, "poses": [{"frame": 3, "pose": [16 numbers, world_from_camera row by row]}, ...]}, in ascending order. Throws
// Error naming the line.
std::vector<PoseUpdates> read_pose_updates(const std::filesystem::path& path);

// A frame, as a file of poses may name it.
struct FrameTime {
  std::int64_t frame = 0;
  double time_s = 0;
};

struct CorrectedPoses {
  std::vector<PoseUpdate> poses;
  std::size_t left_over = 0;  // poses of the file that are of none of the frames
};

// Reads a trajectory: `time x y z qx qy qz qw` (TUM) or `frame x y z qx qy qz qw`, or matrices after such a number, world from
// camera. Whole numbers are frames if that fits as many of these frames as it does as times; else they are times in seconds, each
// for the frame nearest to it, at most 20 ms away. Throws Error: no such file, or neither half of its poses nor half of the
// frames fit.
CorrectedPoses read_corrected_poses(const std::filesystem::path& path, const std::vector<FrameTime>& frames);

}  // namespace panoptic
