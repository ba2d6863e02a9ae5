// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// SUN3D as its authors publish it: image/ and depth/ with names FRAME-MICROSECONDS, whose clocks differ; extrinsics/DATE.txt with
// a 3x4 matrix for each image, the newest of which counts; depth with its bits turned by 3. From their reader,
// https://github.com/PrincetonVision/SUN3Dsfm (depthRead.m) and its loadSUN3D.m.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>

#include "panoptic/base/files.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/dataset_text.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_matching.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

struct TimedFile {
  std::int64_t time_us = 0;
  std::string path;
};

std::vector<TimedFile> timed_files(const fs::path& folder, const char* kind, std::span<const std::string_view> endings) {
  std::vector<TimedFile> files;
  for (const std::string& path : files_in(folder, kind, endings)) {
    const std::string stem = fs::path(path).stem().string();
    const std::size_t dash = stem.find('-');
    std::int64_t time_us = 0;
    if (dash == std::string::npos) continue;
    const auto [end, error] = std::from_chars(stem.data() + dash + 1, stem.data() + stem.size(), time_us);
    if (error == std::errc{} && end == stem.data() + stem.size()) files.push_back({time_us, path});
  }
  std::stable_sort(files.begin(), files.end(), [](const TimedFile& a, const TimedFile& b) { return a.time_us < b.time_us; });
  return files;
}

const TimedFile& nearest(const std::vector<TimedFile>& files, std::int64_t time_us) {
  const auto after = std::lower_bound(files.begin(), files.end(), time_us,
                                      [](const TimedFile& file, std::int64_t time) { return file.time_us < time; });
  if (after == files.begin()) return files.front();
  if (after == files.end()) return files.back();
  const auto before = std::prev(after);
  return time_us - before->time_us <= after->time_us - time_us ? *before : *after;
}

}  // namespace

std::optional<FileRecording> recognise_sun3d(const fs::path& folder, const PairingOptions& pairing) {
  const bool has_poses = is_folder(folder / "extrinsics") || pairing.without_poses;
  if (!is_folder(folder / "image") || !is_folder(folder / "depth") || !has_poses) return std::nullopt;
  const std::vector<TimedFile> color = timed_files(folder, "image", kColorEndings);
  const std::vector<TimedFile> depth = timed_files(folder, "depth", kDepthEndings);
  const auto extrinsics = pairing.without_poses ? std::vector<std::string>() : files_in(folder, "extrinsics", kPoseEndings);
  if (color.empty() || depth.empty() || (extrinsics.empty() && !pairing.without_poses)) return std::nullopt;
  FileRecording recording{"SUN3D", folder, {}, {}};
  if (is_there(folder / "intrinsics.txt")) recording.calibration.depth = read_camera_matrix(folder / "intrinsics.txt");
  recording.depth_bits_turned = 3;
  constexpr double kMicroseconds = 1e-6;
  for (const TimedFile& image : color) {
    FileFrame frame;
    frame.number = static_cast<std::int64_t>(recording.frames.size());
    frame.time_s = kMicroseconds * static_cast<double>(image.time_us);
    frame.color = image.path;
    frame.depth = nearest(depth, image.time_us).path;
    recording.frames.push_back(std::move(frame));
  }
  if (!extrinsics.empty()) give_poses(recording, read_pose_list(folder / extrinsics.back()), folder / extrinsics.back());
  return recording;
}

}  // namespace panoptic
