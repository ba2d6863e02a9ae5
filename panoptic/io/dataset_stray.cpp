// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Recordings of the app Stray Scanner (https://github.com/strayrobots/scanner): docs/format.md there has the files. The pose is
// ARKit's, times half a turn about x (StrayScanner/Helpers/OdometryEncoder.swift): of a camera with x right, y down, z forward,
// in a world with y up. A row of odometry.csv is written with each image of the video (DatasetEncoder.swift). The matrix belongs
// to the images of the video; depth is registered to them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/text.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/image_names.h"
#include "panoptic/io/pose_list.h"
#include "panoptic/io/video.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOdometry = "odometry.csv";
constexpr const char* kMatrix = "camera_matrix.csv";
constexpr const char* kVideo = "rgb.mp4";
constexpr const char* kImages = "rgb";

struct OdometryRow {
  double time_s = 0;
  std::int64_t frame = 0;
  std::optional<Eigen::Matrix4d> pose;
  std::vector<double> intrinsics;  // fx fy cx cy, or none
};

// Where the columns are: the heading tells.
class Columns {
 public:
  explicit Columns(std::span<const std::string_view> heading) : names_(heading.begin(), heading.end()) {
    for (std::string& name : names_) name = lower_case(name);
  }

  // How many words a row needs: up to the last column that is read, in whatever order they are.
  std::size_t needed() const {
    std::size_t last = 0;
    for (const char* name : kRead) last = std::max(last, place(name).value_or(0));
    return last + 1;
  }
  bool has_pose() const {
    return std::all_of(kPose.begin(), kPose.end(), [&](const char* name) { return place(name).has_value(); });
  }
  // The numbers of these columns; none if one of them is not there.
  std::vector<double> pick(std::span<const double> row, std::initializer_list<const char*> names) const {
    std::vector<double> picked;
    for (const char* name : names) {
      const auto at = place(name);
      if (!at) return {};
      picked.push_back(row[*at]);
    }
    return picked;
  }

 private:
  static constexpr std::array kPose = {"x", "y", "z", "qx", "qy", "qz", "qw"};
  static constexpr std::array kRead = {"timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw", "fx", "fy", "cx", "cy"};

  std::optional<std::size_t> place(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    return found == names_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - names_.begin()));
  }

  std::vector<std::string> names_;
};

OdometryRow to_row(const Columns& columns, std::span<const double> numbers, std::size_t position, const std::string& place) {
  constexpr double kMostFrames = 1e9;
  constexpr double kAssumedRate_hz = 60;
  OdometryRow row{static_cast<double>(position) / kAssumedRate_hz, static_cast<std::int64_t>(position), std::nullopt, {}};
  const std::vector<double> time = columns.pick(numbers, {"timestamp"});
  const std::vector<double> frame = columns.pick(numbers, {"frame"});
  if (!time.empty() && std::isfinite(time[0])) row.time_s = time[0];
  if (!frame.empty()) {
    if (!(frame[0] >= 0 && frame[0] <= kMostFrames)) throw Error(fmt::format("{}: {} is no number of a frame", place, frame[0]));
    row.frame = static_cast<std::int64_t>(frame[0]);
  }
  const std::vector<double> n = columns.pick(numbers, {"x", "y", "z", "qx", "qy", "qz", "qw"});
  row.pose = to_matrix4({n[0], n[1], n[2]}, {n[6], n[3], n[4], n[5]});
  row.intrinsics = columns.pick(numbers, {"fx", "fy", "cx", "cy"});
  return row;
}

std::vector<OdometryRow> read_odometry(const fs::path& path) {
  constexpr std::array<std::string_view, 9> kUsual = {"timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw"};
  std::optional<Columns> columns;
  std::vector<OdometryRow> rows;
  for_each_line(path, [&](std::size_t line, std::span<const std::string_view> words) {
    const std::string place = fmt::format("{}:{}", path.string(), line);
    if (!columns && is_heading(words)) {
      columns.emplace(words);
      if (!columns->has_pose()) throw Error(fmt::format("{}: expected a heading with x, y, z, qx, qy, qz, qw", place));
      return;
    }
    // The first versions of the app wrote neither heading nor times.
    if (!columns) columns.emplace(std::span(kUsual).last(words.size() < kUsual.size() ? 7 : kUsual.size()));
    const std::size_t needed = columns->needed();
    if (words.size() < needed)
      throw Error(fmt::format("{}: {} words, expected {}; is the line cut off? Take it out", place, words.size(), needed));
    rows.push_back(to_row(*columns, to_numbers(words.first(needed), path, line), rows.size(), place));
  });
  return rows;
}

// Files by the digits at the end of their names.
NumberedFiles by_number(const std::vector<std::string>& files) {
  NumberedFiles numbered;
  for (const std::string& file : files) {
    const std::string stem = fs::path(file).stem().string();
    const std::string digits = stem.substr(stem.find_last_not_of("0123456789") + 1);
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error == std::errc{} && end == digits.data() + digits.size()) numbered.emplace(number, file);
  }
  return numbered;
}

std::string how_to_extract(const fs::path& root) {
  return fmt::format("ffmpeg -ignore_editlist 1 -noautorotate -i {} -fps_mode passthrough -start_number 0 -q:v 2 {}/%06d.jpg",
                     (root / kVideo).string(), (root / kImages).string());
}

// The extracted image of each row: the n-th of as many, or that of the row's number.
std::vector<std::string> images_of(const fs::path& root, const NumberedFiles& images, const std::vector<OdometryRow>& rows) {
  std::vector<std::string> files;
  if (images.size() == rows.size()) {
    for (const auto& [number, file] : images) files.push_back(file);
    return files;
  }
  const auto is_of_a_row = [&](const auto& image) {
    return std::any_of(rows.begin(), rows.end(), [&](const OdometryRow& row) { return row.frame == image.first; });
  };
  const bool without_gaps =
      std::prev(images.end())->first - images.begin()->first + 1 == static_cast<std::int64_t>(images.size());
  if ((without_gaps && images.size() > 1) || !std::all_of(images.begin(), images.end(), is_of_a_row)) {
    throw Error(fmt::format("{}: {} images for the {} images of the video, so that it is open which is which; extract all: {}",
                            (root / kImages).string(), images.size(), rows.size(), how_to_extract(root)));
  }
  for (const OdometryRow& row : rows) {
    const auto image = images.find(row.frame);
    files.push_back(image == images.end() ? "" : image->second);
  }
  return files;
}

// Sets the frames' colour images, and returns their size.
ImageSize give_color(FileRecording& recording, const std::vector<OdometryRow>& rows) {
  const fs::path& root = recording.root;
  const NumberedFiles images = by_number(files_in(root, kImages, kColorEndings));
  if (images.empty()) {
    if (!is_there(root / kVideo))
      throw Error(fmt::format("{}: Stray Scanner recording without {} (or images in {}/); copy it from the phone", root.string(),
                              kVideo, kImages));
    recording.video = std::make_shared<const Video>(root / kVideo);
    const std::size_t count = recording.video->size();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (i < count) recording.frames[i].video_image = i;
      if (i < count) recording.frames[i].color = kVideo;
      if (i >= count) recording.frames[i].problem = fmt::format("colour image missing: {} has {} images", kVideo, count);
    }
    if (count != rows.size() || recording.video->is_cut_off()) {
      recording.assumed.push_back(fmt::format("{} has {} images{} and {} {} rows: the n-th image belongs to the n-th row", kVideo,
                                              count, recording.video->is_cut_off() ? " and is cut off" : "", kOdometry,
                                              rows.size()));
    }
    return {recording.video->width(), recording.video->height()};
  }
  const std::vector<std::string> files = images_of(root, images, rows);
  for (std::size_t i = 0; i < rows.size(); ++i) recording.frames[i].color = files[i];
  if (is_there(root / kVideo)) recording.assumed.push_back(fmt::format("the images in {}/ are those of {}", kImages, kVideo));
  const Image<Rgb> first = read_rgb(root / images.begin()->second);
  return {first.width(), first.height()};
}

// The size that a matrix belongs to: that of the images, or the one in which ARKit films, if those were made smaller. The
// principal point lies near the middle of it.
ImageSize size_of_matrix(const Camera& camera, ImageSize color, const FileRecording& recording) {
  constexpr double kTolerance = 0.1;
  for (const ImageSize size : {color, ImageSize{1920, 1440}}) {
    const bool near_middle = std::abs((2 * camera.cx + 1) / size.width - 1) < kTolerance &&
                             std::abs((2 * camera.cy + 1) / size.height - 1) < kTolerance;
    const bool is_turned = (color.width < color.height) != (size.width < size.height);
    if (near_middle && !is_turned) return size;
  }
  throw Error(fmt::format(
      "{}: the principal point {:.1f}, {:.1f} of {} is not near the middle of the {}x{} images; were they turned or cut? "
      "Extract them as they are: {}",
      recording.root.string(), camera.cx, camera.cy, kMatrix, color.width, color.height, how_to_extract(recording.root)));
}

void give_cameras(FileRecording& recording, const std::vector<OdometryRow>& rows, ImageSize color) {
  Camera& common = recording.calibration.depth;
  const auto row = std::find_if(rows.begin(), rows.end(), [](const OdometryRow& r) { return !r.intrinsics.empty(); });
  if (is_there(recording.root / kMatrix)) {
    common = read_camera_matrix(recording.root / kMatrix);
  } else if (row != rows.end()) {
    common = to_camera(row->intrinsics, (recording.root / kOdometry).string());
  }
  if (common.fx == 0) return;  // a calibration file may give it
  const ImageSize size = size_of_matrix(common, color, recording);
  const auto sized = [&](Camera camera) {
    camera.width = size.width;
    camera.height = size.height;
    return camera;
  };
  common = sized(common);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    FileFrame& frame = recording.frames[i];
    try {
      if (!rows[i].intrinsics.empty()) frame.camera = sized(to_camera(rows[i].intrinsics, kOdometry));
    } catch (const Error& e) {
      if (frame.problem.empty()) frame.problem = fmt::format("no intrinsics that can be used: {}", e.what());
    }
  }
}

// A row for each depth image, where there is no odometry.
std::vector<OdometryRow> rows_of(const NumberedFiles& depth) {
  constexpr double kAssumedRate_hz = 60;
  std::vector<OdometryRow> rows;
  for (const auto& [number, file] : depth) {
    rows.push_back({static_cast<double>(number) / kAssumedRate_hz, number, std::nullopt, {}});
  }
  return rows;
}

std::string file_of(const NumberedFiles& files, std::int64_t number) {
  const auto found = files.find(number);
  return found == files.end() ? "" : found->second;
}

void add_frames(FileRecording& recording, const std::vector<OdometryRow>& rows, const NumberedFiles& depth) {
  const NumberedFiles confidence = by_number(files_in(recording.root, "confidence", std::array<std::string_view, 1>{".png"}));
  recording.has_confidence = !confidence.empty();
  if (confidence.empty())
    recording.assumed.emplace_back("every depth reading is as sure as others: there are no images in confidence/");
  std::map<std::int64_t, std::string> left = depth;
  for (const OdometryRow& row : rows) {
    FileFrame frame;
    frame.number = row.frame;
    frame.time_s = row.time_s;
    frame.pose = row.pose;
    frame.depth = file_of(depth, row.frame);
    frame.confidence = file_of(confidence, row.frame);
    left.erase(row.frame);
    recording.frames.push_back(std::move(frame));
  }
  for (const auto& [number, file] : left) {
    FileFrame frame;
    frame.number = number;
    frame.depth = file;
    frame.problem = fmt::format("no pose: {} has no row of this frame", kOdometry);
    recording.frames.push_back(std::move(frame));
  }
}

void sort_by_number(FileRecording& recording) {
  std::vector<FileFrame>& frames = recording.frames;
  std::stable_sort(frames.begin(), frames.end(), [](const FileFrame& a, const FileFrame& b) { return a.number < b.number; });
  const auto same =
      std::adjacent_find(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a.number == b.number; });
  if (same == frames.end()) return;
  throw Error(fmt::format("{}: two rows of frame {}; take one out", (recording.root / kOdometry).string(), same->number));
}

}  // namespace

std::optional<FileRecording> recognise_stray(const fs::path& folder, const PairingOptions& pairing) {
  const bool has_color = is_there(folder / kVideo) || is_folder(folder / kImages);
  const bool has_odometry = is_there(folder / kOdometry);
  if (!is_there(folder / kMatrix) && pose_file_in(folder)) return std::nullopt;  // somebody else's
  if (!is_folder(folder / "depth") || !(has_odometry || (has_color && is_there(folder / kMatrix)))) return std::nullopt;
  if (!has_odometry && !pairing.without_poses) {
    throw NoPoses(
        fmt::format("{}: Stray Scanner recording without {}; copy it from the phone, or let panoptic run --track find the poses",
                    folder.string(), kOdometry));
  }
  FileRecording recording{"Stray Scanner", folder, {}, {}};
  const NumberedFiles depth = by_number(files_in(folder, "depth", kDepthEndings));
  const std::vector<OdometryRow> rows = has_odometry ? read_odometry(folder / kOdometry) : rows_of(depth);
  if (rows.empty())
    throw Error(fmt::format("{}: no row and no depth image in it; copy it from the phone again", folder.string()));
  add_frames(recording, rows, depth);
  give_cameras(recording, rows, give_color(recording, rows));
  sort_by_number(recording);
  return recording;
}

}  // namespace panoptic
