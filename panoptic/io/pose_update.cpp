// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/pose_update.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/json_value.h"
#include "panoptic/error.h"
#include "panoptic/io/pose_list.h"

namespace panoptic {
namespace {

constexpr double kNearestTime_s = 0.02;
constexpr std::int64_t kMostFrame = std::int64_t{1} << 53;  // JSON's numbers are exact up to here

// A rigid pose; throws Error with those words if the matrix is none.
Pose require_rigid(const Eigen::Matrix4d& matrix, const std::string& whose) {
  Pose pose;
  pose.matrix() = matrix;
  const bool is_affine = matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-6);
  if (!is_finite(pose) || !is_affine || !is_rigid(pose, 1e-2)) {
    throw Error(fmt::format("{} is no rigid motion; expected world_from_camera, row by row", whose));
  }
  return rigid(matrix);
}

PoseUpdate update_of(const JsonValue& value, const std::string& line) {
  const std::int64_t frame = value.at("frame").integer(0, kMostFrame);
  const std::vector<JsonValue> numbers = value.at("pose").elements();
  if (numbers.size() != 16) value.at("pose").wrong("an array of 16 numbers");
  Eigen::Matrix4d matrix;
  constexpr double kFar = std::numeric_limits<double>::max();
  for (int n = 0; n < 16; ++n) matrix(n / 4, n % 4) = numbers[static_cast<std::size_t>(n)].number(-kFar, kFar);
  return {frame, require_rigid(matrix, fmt::format("{}: the pose of frame {}", line, frame))};
}

PoseUpdates updates_of(std::string_view text, const std::string& line) {
  const std::optional<Json> json = json_in(text);
  if (!json) throw Error(fmt::format("{} is not JSON; expected {{\"at_frame\": N, \"poses\": [...]}}", line));
  const JsonValue value(*json, line);
  PoseUpdates updates{value.at("at_frame").integer(0, kMostFrame), {}};
  for (const JsonValue& pose : value.at("poses").elements()) updates.poses.push_back(update_of(pose, line));
  return updates;
}

// The frame that each pose is of; nothing where it is of none.
using Named = std::vector<std::optional<std::int64_t>>;

std::size_t count(const Named& named) {
  return static_cast<std::size_t>(std::ranges::count_if(named, [](const auto& frame) { return frame.has_value(); }));
}

// By its number. None at all if one is no whole number.
Named frames_by_number(const PoseList& list, const std::vector<FrameTime>& frames) {
  const auto is_whole = [](const ListedPose& pose) {
    return pose.number == std::floor(pose.number) && std::abs(pose.number) <= static_cast<double>(kMostFrame);
  };
  if (!std::ranges::all_of(list.poses, is_whole)) return {};
  std::vector<std::int64_t> known;
  for (const FrameTime& frame : frames) known.push_back(frame.frame);
  std::ranges::sort(known);
  Named named;
  for (const ListedPose& pose : list.poses) {
    const auto frame = static_cast<std::int64_t>(pose.number);
    named.push_back(std::ranges::binary_search(known, frame) ? std::optional(frame) : std::nullopt);
  }
  return named;
}

// By the nearest time, each frame for the pose that is nearest to it. None at all if frames do not have times of their own.
Named frames_by_time(const PoseList& list, std::vector<FrameTime> frames) {
  const auto is_unknown = [](const FrameTime& frame) { return frame.time_s == 0; };
  if (std::ranges::count_if(frames, is_unknown) > 1) std::erase_if(frames, is_unknown);
  std::ranges::sort(frames, {}, &FrameTime::time_s);
  if (frames.empty() || std::ranges::adjacent_find(frames, {}, &FrameTime::time_s) != frames.end()) return {};
  Named named(list.poses.size());
  std::map<std::int64_t, std::pair<double, std::size_t>> nearest_pose;  // by frame: how far in time, and which
  for (std::size_t n = 0; n < list.poses.size(); ++n) {
    const double time_s = list.poses[n].number;
    const auto distance_s = [&](const FrameTime& frame) { return std::abs(frame.time_s - time_s); };
    const auto after = std::ranges::lower_bound(frames, time_s, {}, &FrameTime::time_s);
    const auto begin = after == frames.begin() ? after : after - 1;
    const auto nearest = std::min_element(begin, after == frames.end() ? after : after + 1,
                                          [&](const FrameTime& a, const FrameTime& b) { return distance_s(a) < distance_s(b); });
    if (nearest == frames.end() || distance_s(*nearest) > kNearestTime_s) continue;
    const auto [place, is_first] = nearest_pose.try_emplace(nearest->frame, distance_s(*nearest), n);
    if (!is_first && place->second.first <= distance_s(*nearest)) continue;
    if (!is_first) named[place->second.second] = std::nullopt;
    place->second = {distance_s(*nearest), n};
    named[n] = nearest->frame;
  }
  return named;
}

}  // namespace

std::vector<PoseUpdates> read_pose_updates(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  std::vector<PoseUpdates> all;
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    const std::string place = fmt::format("{} line {}", path.string(), ++number);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    all.push_back(updates_of(line, place));
    if (all.size() > 1 && all[all.size() - 2].at_frame > all.back().at_frame) {
      throw Error(fmt::format("{}: at_frame {} comes after {}; expected ascending order", place, all.back().at_frame,
                              all[all.size() - 2].at_frame));
    }
  }
  if (all.empty()) throw Error(fmt::format("{} holds no corrections", path.string()));
  return all;
}

CorrectedPoses read_corrected_poses(const std::filesystem::path& path, const std::vector<FrameTime>& frames) {
  const PoseList list = read_pose_list(path);
  if (list.key != PoseKey::kNumber) {
    throw Error(
        fmt::format("{}: its poses have no numbers (it looks like {}); expected `time x y z qx qy qz qw` or "
                    "`frame x y z qx qy qz qw`",
                    path.string(), list.form));
  }
  const Named by_number = frames_by_number(list, frames);
  const Named by_time = frames_by_time(list, frames);
  const Named& named = count(by_number) >= count(by_time) ? by_number : by_time;
  const std::size_t fit = count(named);
  if (fit == 0 || 2 * fit < std::min(list.poses.size(), frames.size())) {
    throw Error(fmt::format("{}: of its {} poses {} have the number of a frame of the map, and {} are within {:.0f} ms of one",
                            path.string(), list.poses.size(), count(by_number), count(by_time), 1000 * kNearestTime_s));
  }
  CorrectedPoses corrected{{}, list.poses.size() - fit};
  std::set<std::int64_t> given;
  for (std::size_t n = 0; n < list.poses.size(); ++n) {
    if (!named[n]) continue;
    if (!given.insert(*named[n]).second) throw Error(fmt::format("{} has two poses for frame {}", path.string(), *named[n]));
    const std::string whose = fmt::format("{}: the pose of frame {}", path.string(), *named[n]);
    corrected.poses.push_back({*named[n], require_rigid(list.poses[n].matrix, whose)});
  }
  return corrected;
}

}  // namespace panoptic
