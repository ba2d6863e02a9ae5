// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_formats.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 2> kColor = {".color.png", ".color.jpg"};
constexpr std::array<std::string_view, 1> kDepth = {".depth.png"};
constexpr std::array<std::string_view, 1> kPose = {".pose.txt"};

bool holds_frames(const fs::path& folder) { return !numbered_files(folder, "", "frame-", kDepth).empty(); }

// The folder itself, or the only seq-XX in it. Sequences are recordings of their own: with several, one must be chosen.
std::optional<fs::path> sequence_folder(const fs::path& folder) {
  if (holds_frames(folder)) return folder;
  std::vector<std::string> sequences;
  for (const std::string& name : names_in_folder(folder)) {
    if (name.starts_with("seq-") && holds_frames(folder / name)) sequences.push_back(name);
  }
  if (sequences.empty()) return std::nullopt;
  if (sequences.size() > 1) {
    throw Error(fmt::format("{}: holds {} sequences ({}); name one of them, for example {}", folder.string(), sequences.size(),
                            fmt::join(sequences, ", "), (folder / sequences.front()).string()));
  }
  return folder / sequences.front();
}

}  // namespace

std::optional<FileRecording> recognise_seven_scenes(const fs::path& folder) {
  const std::optional<fs::path> root = sequence_folder(folder);
  if (!root) return std::nullopt;
  FileRecording recording{"7-Scenes", *root, {}, {}};
  recording.calibration.depth = {640, 480, 585, 585, 320, 240};  // the published constants
  recording.calibration.color_is_assumed = true;                 // the published colour camera is another one
  for (const fs::path& place : {*root, root->parent_path()}) {
    if (!is_there(place / "camera-intrinsics.txt")) continue;
    recording.format = "7-Scenes / 3DMatch";
    recording.calibration.depth = read_camera_matrix(place / "camera-intrinsics.txt");
    recording.calibration.color_is_assumed = false;
    break;
  }
  recording.frames = joined(numbered_files(*root, "", "frame-", kColor), numbered_files(*root, "", "frame-", kDepth),
                            numbered_files(*root, "", "frame-", kPose));
  return recording;
}

}  // namespace panoptic
