// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// TUM RGB-D: three lists with time stamps that do not agree; and ICL-NUIM, which numbers its frames instead.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/camera_file.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_list.h"
#include "panoptic/io/time_pairing.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxBracket_s = 0.1;  // poses are interpolated between neighbours that are closer

struct StampedFile {
  double time_s = 0;
  std::string file;
};

double to_time(std::string_view word, const fs::path& path, std::size_t line) {
  const std::optional<double> time = to_number(word);
  if (!time || !std::isfinite(*time))
    throw Error(fmt::format("{}:{}: expected a time stamp, found '{}'", path.string(), line, word));
  // Seconds since 1970 stay below this until the year 5138; larger ones are milli-, micro- or nanoseconds.
  constexpr double kMostSeconds = 1e11;
  constexpr double kThousand = 1000;
  double time_s = *time;
  while (std::abs(time_s) >= kMostSeconds) time_s /= kThousand;
  return time_s;
}

template <typename T>
void sort_by_time(std::vector<T>& list) {
  std::stable_sort(list.begin(), list.end(), [](const T& a, const T& b) { return a.time_s < b.time_s; });
}

// The lines of a list without the heading that some programs write.
void for_each_entry(std::string_view text, const LineCallback& callback) {
  bool is_first = true;
  for_each_line_of(text, kWordSeparators, [&](std::size_t line, std::span<const std::string_view> words) {
    if (!(is_first && is_heading(words))) callback(line, words);
    is_first = false;
  });
}

std::vector<StampedFile> read_file_list(const fs::path& path) {
  std::vector<StampedFile> list;
  for_each_entry(read_file(path), [&](std::size_t line, std::span<const std::string_view> words) {
    if (words.size() != 2)
      throw Error(fmt::format("{}:{}: expected 'time file', found {} words", path.string(), line, words.size()));
    list.push_back({to_time(words[0], path, line), with_slashes(words[1])});
  });
  sort_by_time(list);
  return list;
}

std::vector<PoseSample> read_poses(const fs::path& path) {
  constexpr std::size_t kColumns = 8;
  std::vector<PoseSample> poses;
  const std::string text = read_file(path);
  const bool w_first = names_w_first(text).value_or(false);
  for_each_entry(text, [&](std::size_t line, std::span<const std::string_view> words) {
    if (words.size() != kColumns && words.size() != kColumns + 1) {  // RTAB-Map adds a number at the end
      throw Error(fmt::format("{}:{}: expected 'time tx ty tz qx qy qz qw', found {} words", path.string(), line, words.size()));
    }
    const double time_s = to_time(words[0], path, line);
    const std::vector<double> n = to_numbers(words.subspan(1), path, line);
    const Eigen::Quaterniond rotation =
        w_first ? Eigen::Quaterniond(n[3], n[4], n[5], n[6]) : Eigen::Quaterniond(n[6], n[3], n[4], n[5]);
    poses.push_back({time_s, {n[0], n[1], n[2]}, rotation});
  });
  sort_by_time(poses);
  return poses;
}

// Two cameras of one rate whose clocks are apart: as many images of either kind, the same difference throughout, and that less
// than half of the time between two images. The n-th of one then belongs to the n-th of the other. Returns that difference.
std::optional<double> constant_offset_s(const std::vector<StampedFile>& color, const std::vector<StampedFile>& depth) {
  constexpr std::size_t kFewest = 3;
  constexpr double kJitter = 0.25;  // of the time between two images
  if (color.size() != depth.size() || color.size() < kFewest) return std::nullopt;
  std::vector<double> differences_s;
  for (std::size_t i = 0; i < color.size(); ++i) differences_s.push_back(color[i].time_s - depth[i].time_s);
  const auto [least, most] = std::minmax_element(differences_s.begin(), differences_s.end());
  const double period_s = (depth.back().time_s - depth.front().time_s) / static_cast<double>(depth.size() - 1);
  const double offset_s = (*least + *most) / 2;
  const bool is_constant = *most - *least <= kJitter * period_s && std::abs(offset_s) < period_s / 2;
  return is_constant ? std::optional(offset_s) : std::nullopt;
}

// The times of a list.
std::vector<double> times_of(const std::vector<StampedFile>& list) {
  std::vector<double> times_s;
  for (const StampedFile& file : list) times_s.push_back(file.time_s);
  return times_s;
}

struct PublishedCamera {
  Camera camera{640, 480, 525, 525, 319.5, 239.5};  // the one that the set's depth images were registered with
  Distortion distortion;
  bool is_known = false;
};

// The constants that the authors of the set give for each of its three sensors
// (https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats), told by the name of the folder. Depth was registered to the
// pixels of the colour images, distorted as they are.
PublishedCamera published_camera(const std::string& name) {
  const auto is = [&](const char* a, const char* b) {
    return name.find(a) != std::string::npos || name.find(b) != std::string::npos;
  };
  if (is("freiburg1", "fr1")) return {{640, 480, 517.3, 516.5, 318.6, 255.3}, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}, true};
  if (is("freiburg2", "fr2")) return {{640, 480, 520.9, 521.0, 325.1, 249.7}, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}, true};
  if (is("freiburg3", "fr3")) return {{640, 480, 535.4, 539.2, 320.1, 247.6}, {}, true};
  return {};
}

struct ImageLists {
  std::vector<StampedFile> color;
  std::vector<StampedFile> depth;
  std::vector<TimePair> pairs;
  double tolerance_s = kMaxTimeDifference_s;
  std::string assumed;  // a line for the user, if the images were not paired by their time stamps
};

ImageLists read_separate_lists(const fs::path& folder, const PairingOptions& pairing) {
  const double tolerance_s = pairing.tolerance_s.value_or(kMaxTimeDifference_s);
  ImageLists lists{read_file_list(folder / "rgb.txt"), read_file_list(folder / "depth.txt"), {}, tolerance_s, ""};
  lists.pairs = paired_by_time(times_of(lists.color), times_of(lists.depth), tolerance_s);
  const std::optional<double> offset_s = constant_offset_s(lists.color, lists.depth);
  if (lists.pairs.size() == lists.color.size() || !offset_s || pairing.tolerance_s) return lists;
  for (std::size_t i = 0; i < lists.color.size(); ++i) lists.pairs[i] = {i, i};
  lists.pairs.resize(lists.color.size());
  constexpr double kMilli = 1000;
  lists.assumed = fmt::format("colour images are {:.0f} ms {} depth images throughout: paired in their order",
                              kMilli * std::abs(*offset_s), *offset_s > 0 ? "after" : "before");
  return lists;
}

// 'time file time file', with colour or depth first: the folder names tell.
ImageLists read_associations(const fs::path& path) {
  constexpr std::size_t kColumns = 4;
  ImageLists lists;
  for_each_entry(read_file(path), [&](std::size_t line, std::span<const std::string_view> words) {
    if (words.size() != kColumns) {
      const bool has_pose = words.size() > kColumns + 6;
      throw Error(fmt::format("{}:{}: expected 'time file time file', found {} words{}", path.string(), line, words.size(),
                              has_pose ? "; are the last of them a pose? Put those into groundtruth.txt, 'time tx ty tz qx qy qz "
                                         "qw' a line, and leave them out here"
                                       : ""));
    }
    const bool depth_first = words[1].find("depth") != std::string_view::npos;
    const std::size_t d = depth_first ? 0 : 2;
    const std::size_t c = depth_first ? 2 : 0;
    lists.pairs.push_back({lists.color.size(), lists.depth.size()});
    lists.color.push_back({to_time(words[c], path, line), with_slashes(words[c + 1])});
    lists.depth.push_back({to_time(words[d], path, line), with_slashes(words[d + 1])});
  });
  return lists;
}

std::vector<FileFrame> frames_of(const ImageLists& lists, const std::vector<PoseSample>& poses) {
  std::vector<FileFrame> frames;
  for (const TimePair& pair : lists.pairs) {
    FileFrame frame;
    frame.time_s = pair.depth ? lists.depth[*pair.depth].time_s : lists.color[*pair.color].time_s;
    if (pair.color) frame.color = lists.color[*pair.color].file;
    if (pair.depth) frame.depth = lists.depth[*pair.depth].file;
    frame.pose = pose_at(poses, frame.time_s, kMaxBracket_s);
    if (!pair.depth) frame.problem = fmt::format("no depth image within {} s", lists.tolerance_s);
    if (!pair.color) frame.problem = fmt::format("no colour image within {} s", lists.tolerance_s);
    if (frame.problem.empty() && !frame.pose) frame.problem = fmt::format("no pose within {} s", kMaxTimeDifference_s);
    frames.push_back(std::move(frame));
  }
  sort_by_time(frames);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].number = static_cast<std::int64_t>(i);
  return frames;
}

// "1.5 to 2.25 s", for the user.
template <typename T>
std::string range_text(const std::vector<T>& sorted) {
  if (sorted.empty()) return "nowhere, for it is empty";
  return fmt::format("from {:.3f} to {:.3f} s", sorted.front().time_s, sorted.back().time_s);
}

// Lists of another clock or unit leave every image without a partner, or without a pose.
void require_one_clock(const fs::path& folder, const ImageLists& lists, const std::vector<PoseSample>& poses,
                       const std::vector<FileFrame>& frames) {
  const auto any = [&](auto test) { return std::any_of(frames.begin(), frames.end(), test); };
  if (frames.empty()) return;
  constexpr const char* kRemedy = "are they of one clock, and in one unit?";
  if (!any([](const FileFrame& f) { return !f.color.empty() && !f.depth.empty(); })) {
    throw Error(fmt::format(
        "{}: no colour image lies within {} s of a depth image: the time stamps of colour run {}, those of depth {}; {} "
        "--pair-tolerance S allows more",
        folder.string(), lists.tolerance_s, range_text(lists.color), range_text(lists.depth), kRemedy));
  }
  if (!any([](const FileFrame& f) { return f.pose.has_value(); })) {
    throw Error(
        fmt::format("{}: no pose lies within {} s of an image: the time stamps of poses run {}, those of the depth images {}; {}",
                    folder.string(), kMaxTimeDifference_s, range_text(poses), range_text(lists.depth), kRemedy));
  }
}

// ICL-NUIM renders with y up (its fy is negative). Turning y round in the camera and in the world makes it a usual camera.
void turn_y_round(std::vector<FileFrame>& frames) {
  const Eigen::Matrix4d flip = Eigen::Vector4d(1, -1, 1, 1).asDiagonal();
  for (FileFrame& frame : frames) {
    if (frame.pose) frame.pose = flip * *frame.pose * flip;
  }
}

// ICL-NUIM without a list: rgb/N.png and depth/N.png belong together.
ImageLists list_numbered_folders(const fs::path& folder) {
  FileRecording recording{"ICL-NUIM", folder, {}, {}};
  add_frames_by_name(recording, {files_in(folder, "rgb", kColorEndings), files_in(folder, "depth", kDepthEndings), {}});
  ImageLists lists;
  for (const FileFrame& frame : recording.frames) {
    if (frame.color.empty() || frame.depth.empty()) continue;
    lists.pairs.push_back({lists.color.size(), lists.depth.size()});
    lists.color.push_back({static_cast<double>(frame.number), frame.color});
    lists.depth.push_back({static_cast<double>(frame.number), frame.depth});
  }
  return lists;
}

// The list of pairs, under the names that associate.py's users and ETH3D give it.
std::optional<std::string> association_file(const fs::path& folder) {
  constexpr std::array<std::string_view, 5> kNames = {"associations.txt", "associated.txt", "association.txt", "associate.txt",
                                                      "assoc.txt"};
  return first_named(folder, kNames);
}

std::optional<fs::path> icl_trajectory(const fs::path& folder) {
  for (const std::string& name : names_in_folder(folder)) {
    if (name.ends_with(".gt.freiburg") && !name.starts_with('.')) return folder / name;
  }
  return std::nullopt;
}

void set_camera(FileRecording& recording, bool is_icl) {
  Calibration& calibration = recording.calibration;
  calibration.depth_scale = 5000;
  if (is_icl) {
    calibration.depth = {640, 480, 481.2, 480, 319.5, 239.5};
  } else if (is_there(recording.root / "calibration.txt")) {  // ETH3D's: depth is registered to colour, without distortion
    recording.format = "TUM RGB-D (ETH3D)";
    read_camera_file(recording.root / "calibration.txt", calibration);
    calibration.scale_is_assumed = !is_there(recording.root / "associated.txt");
  } else {
    const PublishedCamera published = published_camera(recording.root.filename().string());
    calibration.depth = published.camera;
    calibration.depth_distortion = published.distortion;
    calibration.camera_is_assumed = !published.is_known;
    calibration.scale_is_assumed = !published.is_known;
  }
}

}  // namespace

std::optional<FileRecording> recognise_tum(const fs::path& folder, const PairingOptions& pairing) {
  const bool separate = is_there(folder / "rgb.txt") && is_there(folder / "depth.txt");
  const std::optional<std::string> associations = separate ? std::nullopt : association_file(folder);
  const std::optional<fs::path> icl = icl_trajectory(folder);
  const bool in_folders = icl && is_folder(folder / "rgb") && is_folder(folder / "depth");
  if (!separate && !associations && !in_folders) return std::nullopt;
  const fs::path trajectory = icl.value_or(folder / "groundtruth.txt");
  if (!pairing.without_poses && !is_there(trajectory)) {
    throw NoPoses(fmt::format(
        "{}: TUM RGB-D recording without groundtruth.txt; put a trajectory there ('time tx ty tz qx qy qz qw' a line), "
        "or let panoptic run --track find the poses",
        folder.string()));
  }
  FileRecording recording{icl ? "ICL-NUIM" : "TUM RGB-D", folder, {}, {}};
  set_camera(recording, icl.has_value());
  const ImageLists lists = separate       ? read_separate_lists(folder, pairing)
                           : associations ? read_associations(folder / *associations)
                                          : list_numbered_folders(folder);
  if (!lists.assumed.empty()) recording.assumed.push_back(lists.assumed);
  if (pairing.without_poses) {
    recording.frames = frames_of(lists, {});
    return recording;
  }
  const std::vector<PoseSample> poses = read_poses(trajectory);
  recording.frames = frames_of(lists, poses);
  require_one_clock(folder, lists, poses, recording.frames);
  if (icl) turn_y_round(recording.frames);
  return recording;
}

}  // namespace panoptic
