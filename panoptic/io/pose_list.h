// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses in one text file, in any of the forms that people write. Which form it is shows by counting numbers and by which reading
// gives rotations; `form` says what was taken.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/geometry.h"

namespace panoptic {

// The key that a pose has on its line: nothing, a number (an index or a time stamp) or the name of an image.
enum class PoseKey { kNone, kNumber, kName };

struct ListedPose {
  double number = 0;
  std::string name;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();  // as stored; may be no rigid transform
};

struct PoseList {
  PoseKey key = PoseKey::kNone;
  std::vector<ListedPose> poses;
  std::string form;  // "4x4 matrices row by row"
};

// True if a text names qw before qx, as comments and headings of trajectories do, false if after; nothing if it does not name
// both.
std::optional<bool> names_w_first(std::string_view text);

// A line each: 16 numbers (4x4, row by row or column by column), 12 (3x4, or a rotation and a position), 7 (position and
// quaternion in either order; w last after a position and first before it, unless a comment names qw and qx), each also with a
// number or a name first; 9 (time, position, quaternion, a number). Or rows of 4 numbers that make 4x4 or 3x4 matrices, each also
// after a line of up to three numbers or a name, as in Redwood's log. Commas, semicolons and brackets are blanks, decimal commas
// are read, and a first line of words alone is a heading. Throws Error naming file and line for anything else.
PoseList read_pose_list(const std::filesystem::path& path);

// One pose from 16, 12, 8 (after a number) or 7 numbers, as above; nothing for any other count.
std::optional<Eigen::Matrix4d> to_pose(std::span<const double> numbers);

// A quaternion that is none gives a zero rotation, which is then refused with the reason that belongs to it.
Eigen::Matrix4d to_matrix4(const Vec3d& position, const Eigen::Quaterniond& rotation);

}  // namespace panoptic
