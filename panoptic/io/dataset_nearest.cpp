// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Why a folder is no recording: the format that it comes nearest to, and what it lacks of it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/text.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/dataset_text.h"
#include "panoptic/io/image_names.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

// A part of a format: what to call it, and names of which one must be there. A star stands for anything.
struct FormatPart {
  std::string what;
  std::vector<std::string> names;
};

struct FormatParts {
  const char* format;
  std::vector<FormatPart> parts;
};

const std::vector<FormatParts>& formats() {
  static const std::vector<FormatPart> kImages = {{"images/ (or color/, rgb/)", {kColorFolders.begin(), kColorFolders.end()}},
                                                  {"depth/", {kDepthFolders.begin(), kDepthFolders.end()}}};
  static const std::vector<FormatParts> kFormats = {
      {"ScanNet export", {{"color/", {"color"}}, {"depth/", {"depth"}}, {"pose/", {"pose", "poses"}}}},
      {"7-Scenes",
       {{"frame-*.color.png", {"frame-*.color.*"}},
        {"frame-*.depth.png", {"frame-*.depth.*"}},
        {"frame-*.pose.txt", {"frame-*.pose.txt"}}}},
      {"TUM RGB-D", {{"rgb.txt", {"rgb.txt"}}, {"depth.txt", {"depth.txt"}}, {"groundtruth.txt", {"groundtruth.txt"}}}},
      {"Replica", {{"results/", {"results"}}, {"traj.txt", {"traj.txt"}}}},
      {"SUN3D",
       {{"image/", {"image"}}, {"depth/", {"depth"}}, {"extrinsics/", {"extrinsics"}}, {"intrinsics.txt", {"intrinsics.txt"}}}},
      {"ARKitScenes",
       {{"lowres_wide/", {"lowres_wide", "vga_wide", "wide"}},
        {"lowres_depth/", {"lowres_depth"}},
        {"lowres_wide.traj", {"lowres_wide.traj"}}}},
      {"Stray Scanner",
       {{"odometry.csv", {"odometry.csv"}},
        {"camera_matrix.csv", {"camera_matrix.csv"}},
        {"depth/", {"depth"}},
        {"rgb.mp4 (or rgb/)", {"rgb.mp4", "rgb"}}}},
      {"Record3D", {{"metadata.json", {"metadata.json"}}, {"rgb/", {"rgb"}}, {"depth/", {"depth"}}}},
      {"RTAB-Map export",
       {{"rgb/", {"rgb", "*_rgb"}},
        {"depth/", {"depth", "*_depth"}},
        {"calib/", {"calib", "*_calib"}},
        {"camera_poses.txt", {"camera_poses.txt", "*_camera_poses.txt", "poses.txt", "*_poses.txt"}}}},
      {"Open3D recorder",
       {{"color/", {"color"}},
        {"depth/", {"depth"}},
        {"camera_intrinsic.json", {"camera_intrinsic.json", "intrinsic.json"}},
        {"trajectory.log", {"trajectory.log"}}}},
      {"plain folder",
       {kImages[0],
        kImages[1],
        {"poses.txt (or poses/)", {"poses.txt", "poses", "pose"}},
        {"K.txt", {"k.txt", "intrinsic*.txt"}}}},
      {"flat folder",
       {{"colour images", {"*[0-9].jpg", "*color*.png", "*rgb*.png"}},
        {"depth images", {"*[0-9].png", "*depth*.png"}},
        {"a pose for each image, of its name, or poses.txt", {"*[0-9].txt", "*pose*.txt"}}}}};
  return kFormats;
}

// One star matches any text, "[0-9]" a digit.
bool fits(std::string_view name, std::string_view pattern) {
  constexpr std::string_view kDigit = "[0-9]";
  if (pattern.empty() || name.empty()) return name.empty() && pattern.find_first_not_of('*') == std::string_view::npos;
  if (pattern.front() == '*') return fits(name, pattern.substr(1)) || fits(name.substr(1), pattern);
  const bool any_digit = pattern.starts_with(kDigit);
  const bool same = any_digit ? name.front() >= '0' && name.front() <= '9' : name.front() == pattern.front();
  return same && fits(name.substr(1), pattern.substr(any_digit ? kDigit.size() : 1));
}

bool is_present(const FormatPart& part, const std::vector<std::string>& names) {
  return std::any_of(part.names.begin(), part.names.end(), [&](const std::string& pattern) {
    return std::any_of(names.begin(), names.end(), [&](const std::string& name) { return fits(name, pattern); });
  });
}

struct Nearness {
  const FormatParts* format = nullptr;
  std::vector<std::string> present;
  std::vector<std::string> missing;
};

Nearness nearness(const FormatParts& format, const std::vector<std::string>& names) {
  Nearness result{&format, {}, {}};
  for (const FormatPart& part : format.parts) (is_present(part, names) ? result.present : result.missing).push_back(part.what);
  return result;
}

// The format that lacks the fewest parts, of those that are there at all.
Nearness nearest_format(const std::vector<std::string>& names) {
  Nearness best;
  for (const FormatParts& format : formats()) {
    Nearness candidate = nearness(format, names);
    if (candidate.present.empty()) continue;
    const bool nearer = best.format == nullptr || candidate.missing.size() < best.missing.size() ||
                        (candidate.missing.size() == best.missing.size() && candidate.present.size() > best.present.size());
    if (nearer) best = std::move(candidate);
  }
  return best;
}

std::vector<std::string> lower_names(const fs::path& folder) {
  constexpr std::size_t kMostLookedAt = 10000;
  std::vector<std::string> names;
  for (const std::string& name : names_in_folder(folder)) {
    if (names.size() == kMostLookedAt) break;
    if (!name.starts_with('.')) names.push_back(lower_case(name));
  }
  return names;
}

// Poses in a form that is not read, where a list of them is missing.
std::string poses_of_another_form(const std::vector<std::string>& names) {
  for (const char* pattern :
       {"*pose*.json", "*traj*.json", "transforms*.json", "*pose*.npy", "*pose*.npz", "*traj*.npy", "*pose*.csv"}) {
    const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) { return fits(name, pattern); });
    if (found != names.end())
      return fmt::format("; poses are not read from {}: write them to poses.txt, the 16 numbers of a 4x4 matrix a line", *found);
  }
  return {};
}

std::string to_text(const Nearness& nearest, const std::vector<std::string>& names) {
  if (nearest.format == nullptr) return {};
  return fmt::format(
      "nearest is {}: it has {} and lacks {}{}", nearest.format->format, fmt::join(nearest.present, ", "),
      nearest.missing.empty() ? "images that can be told apart" : fmt::format("{}", fmt::join(nearest.missing, ", ")),
      poses_of_another_form(names));
}

// A file among these that has to be unpacked or converted first, and how; nothing if there is none.
std::string packed_in(const std::vector<std::string>& names) {
  struct Kind {
    const char* pattern;
    const char* remedy;
  };
  constexpr Kind kKinds[] = {{"*.zip", "unpack it"},
                             {"*.tar", "unpack it"},
                             {"*.tgz", "unpack it"},
                             {"*.tar.gz", "unpack it"},
                             {"*.7z", "unpack it"},
                             {"metadata.yaml", "the bag that it describes (.db3, .mcap) is not beside it"},
                             {"*.r3d", ".r3d is not read: export it in the app as EXR + RGB, which is a folder EXR_RGBD"},
                             {"*.mkv", "a video is not read: export its images (ffmpeg -i FILE color/%06d.png)"},
                             {"*.mp4", "a video is not read: export its images (ffmpeg -i FILE color/%06d.png)"},
                             {"*.h264", "the ScanNet app's files are not read: convert them to .sens"}};
  for (const Kind& kind : kKinds) {
    const auto found =
        std::find_if(names.begin(), names.end(), [&](const std::string& name) { return fits(name, kind.pattern); });
    if (found != names.end()) return fmt::format("found {}; {}", *found, kind.remedy);
  }
  return {};
}

// A folder some levels below that has most of a format.
std::optional<fs::path> recording_below(const fs::path& folder, int levels) {
  for (const std::string& name : names_in_folder(folder)) {
    const fs::path path = folder / name;
    if (name.starts_with('.') || !is_folder(path)) continue;
    const Nearness nearest = nearest_format(lower_names(path));
    if (nearest.missing.size() < nearest.present.size() || is_bag_recording(path)) return path;
    if (auto below = levels > 1 ? recording_below(path, levels - 1) : std::nullopt) return below;
  }
  return std::nullopt;
}

}  // namespace

std::string why_no_recording(const fs::path& folder) {
  if (!is_folder(folder)) return packed_in({lower_case(folder.filename().string())});
  const std::vector<std::string> names = lower_names(folder);
  const Nearness nearest = nearest_format(names);
  const bool has_half = !nearest.present.empty() && nearest.missing.size() <= nearest.present.size();
  if (has_half) return to_text(nearest, names);
  if (std::string packed = packed_in(names); !packed.empty()) return packed;
  if (const auto below = recording_below(folder, 2)) return fmt::format("is {} meant?", below->string());
  return to_text(nearest, names);
}

bool has_unread_poses(const std::filesystem::path& folder) { return !poses_of_another_form(lower_names(folder)).empty(); }

}  // namespace panoptic
