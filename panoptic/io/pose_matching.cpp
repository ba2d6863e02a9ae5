// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/pose_matching.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "panoptic/error.h"
#include "panoptic/io/dataset_text.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

std::size_t color_count(const std::vector<FileFrame>& frames) {
  return static_cast<std::size_t>(
      std::count_if(frames.begin(), frames.end(), [](const FileFrame& frame) { return !frame.color.empty(); }));
}

[[noreturn]] void refuse_count(const fs::path& path, std::size_t poses, std::size_t images) {
  throw Error(
      fmt::format("{}: {} poses for {} colour images; expected one for each image, in the order of their names, or with "
                  "the image's name or number before each",
                  path.string(), poses, images));
}

// The positions of the frames with a colour image: by number, or by the image's name as text.
std::vector<std::size_t> positions_of(const std::vector<FileFrame>& frames, bool as_text) {
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].color.empty()) positions.push_back(i);
  }
  if (as_text) std::sort(positions.begin(), positions.end(), [&](auto a, auto b) { return frames[a].color < frames[b].color; });
  return positions;
}

void give_in_order(FileRecording& recording, const PoseList& list, const fs::path& path) {
  std::vector<FileFrame>& frames = recording.frames;
  const std::vector<std::size_t> by_number = positions_of(frames, false);
  if (list.poses.size() != by_number.size()) refuse_count(path, list.poses.size(), by_number.size());
  for (std::size_t i = 0; i < by_number.size(); ++i) frames[by_number[i]].pose = list.poses[i].matrix;
  const std::vector<std::size_t> by_text = positions_of(frames, true);
  if (by_text == by_number) return;
  recording.other_order = {fs::path(path).lexically_relative(recording.root).string(), {}};
  recording.other_order.poses.resize(frames.size());
  for (std::size_t i = 0; i < by_text.size(); ++i) recording.other_order.poses[by_text[i]] = list.poses[i].matrix;
}

// Counts the frames that there is a pose for, and gives it to them where `give`.
template <typename Key>
std::size_t matched(std::vector<FileFrame>& frames, const std::map<Key, const ListedPose*>& poses,
                    const std::function<std::optional<Key>(const FileFrame&)>& key_of, bool give) {
  std::size_t count = 0;
  for (FileFrame& frame : frames) {
    const std::optional<Key> key = key_of(frame);
    const auto found = key ? poses.find(*key) : poses.end();
    if (found == poses.end()) continue;
    ++count;
    if (give) frame.pose = found->second->matrix;
  }
  return count;
}

void give_by_name(std::vector<FileFrame>& frames, const PoseList& list, const fs::path& path) {
  const auto name_of = [](const std::string& file) {
    const std::string name = fs::path(file).filename().string();
    const std::size_t ending = name.rfind('.');
    const bool has_ending = ending != std::string::npos && name.size() - ending <= 5;  // ".jpeg"; time stamps have longer ones
    return has_ending ? name.substr(0, ending) : name;
  };
  std::map<std::string, const ListedPose*> poses;
  for (const ListedPose& pose : list.poses) poses[name_of(with_slashes(pose.name))] = &pose;
  const auto key = [&](auto member) {
    return [&name_of, member](const FileFrame& f) -> std::optional<std::string> { return name_of(f.*member); };
  };
  if (matched<std::string>(frames, poses, key(&FileFrame::color), true) > 0) return;
  if (matched<std::string>(frames, poses, key(&FileFrame::depth), true) > 0) return;
  throw Error(fmt::format("{}: names no image of the recording; the first is '{}', the images begin with {}", path.string(),
                          list.poses.front().name, frames.front().color));
}

void give_by_number(FileRecording& recording, const PoseList& list, const fs::path& path) {
  std::vector<FileFrame>& frames = recording.frames;
  constexpr double kPerSecond = 1e4;  // time stamps are the same to a tenth of a millisecond
  std::map<std::int64_t, const ListedPose*> by_number;
  std::map<std::int64_t, const ListedPose*> by_time;
  for (const ListedPose& pose : list.poses) {
    if (!(std::abs(pose.number) < 9e18)) continue;
    if (pose.number == std::floor(pose.number)) by_number[static_cast<std::int64_t>(pose.number)] = &pose;
    if (std::abs(pose.number) < 9e14) by_time[std::llround(pose.number * kPerSecond)] = &pose;
  }
  const auto number = [](const FileFrame& f) -> std::optional<std::int64_t> { return f.number; };
  const auto time = [](const FileFrame& f) -> std::optional<std::int64_t> { return std::llround(f.time_s * kPerSecond); };
  const std::size_t numbers = matched<std::int64_t>(frames, by_number, number, false);
  const std::size_t times = matched<std::int64_t>(frames, by_time, time, false);
  const bool all = std::max(numbers, times) == std::min(list.poses.size(), frames.size());
  if (!all && list.poses.size() == color_count(frames)) {
    give_in_order(recording, list, path);
    recording.assumed.push_back(fmt::format("{}: its poses begin with number {} and the images with {}: they are taken in order",
                                            path.filename().string(), list.poses.front().number, frames.front().number));
    return;
  }
  if (std::max(numbers, times) == 0) refuse_count(path, list.poses.size(), color_count(frames));
  matched<std::int64_t>(frames, numbers >= times ? by_number : by_time,
                        numbers >= times ? std::function<std::optional<std::int64_t>(const FileFrame&)>(number) : time, true);
}

}  // namespace

void give_poses(FileRecording& recording, const PoseList& list, const fs::path& path) {
  if (list.poses.empty()) throw Error(fmt::format("{}: holds no poses", path.string()));
  if (recording.frames.empty()) return;
  if (list.key == PoseKey::kName) give_by_name(recording.frames, list, path);
  if (list.key == PoseKey::kNumber) give_by_number(recording, list, path);
  if (list.key == PoseKey::kNone) give_in_order(recording, list, path);
  recording.assumed.push_back(
      fmt::format("{}: {}, taken from camera (x right, y down, z forward) to world", path.filename().string(), list.form));
}

}  // namespace panoptic
