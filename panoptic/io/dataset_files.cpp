// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/dataset_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <utility>
#include <variant>

#include "panoptic/base/depth_image.h"
#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_frame.h"
#include "panoptic/io/dataset_left_out.h"
#include "panoptic/io/pose_list.h"

namespace panoptic {
namespace {

constexpr double kAssumedRate_hz = 30;

// A frame that has to be skipped; caught in read().
struct Unusable {
  std::string reason;
};

template <typename Read>
auto read_image(const FileRecording& recording, const std::string& file, std::string_view what, const Read& read) {
  const std::filesystem::path path = recording.root / file;
  if (file.empty()) throw Unusable{fmt::format("{} image missing", what)};
  try {
    if (!is_there(path)) throw Unusable{fmt::format("{} image missing: {}", what, file)};
    return read(path);
  } catch (const FileError& e) {
    throw Unusable{fmt::format("{} image unreadable: {}", what, e.what())};
  } catch (const Error& e) {
    throw Unusable{fmt::format("{} image unreadable: {}", what, e.what())};
  }
}

DepthImage read_raw_depth(const FileRecording& recording, const FileFrame& frame) {
  return read_image(recording, frame.depth, "depth", [](const std::filesystem::path& path) { return read_depth_image(path); });
}

Image<float> read_depth(const FileRecording& recording, const FileFrame& frame) {
  DepthImage depth = read_raw_depth(recording, frame);
  if (auto* floats = std::get_if<Image<float>>(&depth)) return to_metres(std::move(*floats), recording.calibration);
  auto& whole = std::get<Image<std::uint16_t>>(depth);
  std::transform(whole.data(), whole.data() + whole.size(), whole.data(),
                 [&](std::uint16_t value) { return std::rotr(value, recording.depth_bits_turned); });
  return to_metres(whole, recording.calibration);
}

Image<Rgb> read_color(const FileRecording& recording, const FileFrame& frame) {
  return read_image(recording, frame.color, "colour", [](const std::filesystem::path& path) { return read_rgb(path); });
}

Eigen::Matrix4d read_pose(const FileRecording& recording, const FileFrame& frame) {
  if (frame.pose) return *frame.pose;
  const std::filesystem::path path = recording.root / frame.pose_file;
  if (frame.pose_file.empty()) throw Unusable{"pose missing"};
  try {
    if (!is_there(path)) throw Unusable{"pose missing"};
    if (const auto matrix = to_pose(read_numbers(path))) return *matrix;
  } catch (const FileError& e) {
    throw Unusable{fmt::format("pose unreadable: {}", e.what())};
  } catch (const Error&) {  // the same to the user as a wrong count of numbers
  }
  throw Unusable{
      fmt::format("pose unreadable: {} is no pose: neither a 4x4 or 3x4 matrix nor position and quaternion", frame.pose_file)};
}

ImageSize size_of(const Image<Rgb>& image) { return {image.width(), image.height()}; }
ImageSize size_of(const DepthImage& depth) {
  return std::visit([](const auto& image) { return ImageSize{image.width(), image.height()}; }, depth);
}

// The first readable image of one kind.
template <typename Read>
auto first_image(const FileRecording& recording, const Read& read) {
  std::string first_reason = "there are no frames";
  for (const FileFrame& frame : recording.frames) {
    try {
      return read(recording, frame);
    } catch (const Unusable& e) {
      if (&frame == &recording.frames.front()) first_reason = e.reason;
    }
  }
  throw Error(
      fmt::format("{}: {} recording without one usable pair of images (first frame: {}); check that it was unpacked whole",
                  recording.root.string(), recording.format, first_reason));
}

RecordingNotes notes_of(const FileRecording& recording) {
  const Calibration& c = recording.calibration;
  RecordingNotes notes{recording.assumed, files_left_out(recording), c.depth_scale};
  constexpr const char* kRemedy = "; --calibration FILE.toml gives others";
  if (c.camera_is_assumed) {
    notes.assumed.push_back(fmt::format("focal length {:.1f}, {:.1f} pixels at {}x{}, since no file gives it{}", c.depth.fx,
                                        c.depth.fy, c.depth.width, c.depth.height, kRemedy));
  }
  if (c.scale_is_assumed) {
    notes.assumed.push_back(fmt::format("{:g} raw depth units a metre, since no file says so{}", c.depth_scale, kRemedy));
  }
  if (c.color_is_assumed) {
    notes.assumed.push_back(fmt::format("colour images show what depth images show, pixel for pixel{}", kRemedy));
  }
  return notes;
}

}  // namespace

std::vector<FileFrame> joined(const NumberedFiles& color, const NumberedFiles& depth, const NumberedFiles& poses) {
  std::map<std::int64_t, FileFrame> frames;
  for (const auto& [number, path] : color) frames[number].color = path;
  for (const auto& [number, path] : depth) frames[number].depth = path;
  std::vector<FileFrame> result;
  result.reserve(frames.size());
  for (auto& [number, frame] : frames) {
    frame.number = number;
    frame.time_s = static_cast<double>(number) / kAssumedRate_hz;
    const auto pose = poses.find(number);
    if (pose != poses.end()) frame.pose_file = pose->second;
    result.push_back(std::move(frame));
  }
  return result;
}

FileDataset::FileDataset(FileRecording recording) : recording_(std::move(recording)) {
  const DepthImage depth = first_image(recording_, read_raw_depth);
  const ImageSize color = size_of(first_image(recording_, read_color));
  Calibration& calibration = recording_.calibration;
  if (calibration.scale_is_assumed && std::holds_alternative<Image<float>>(depth)) calibration.depth_scale = 1;  // metres
  calibration = fitted(calibration, size_of(depth), color, recording_.root.string());
  notes_ = notes_of(recording_);
}

std::string FileDataset::description() const {
  const Camera& depth = recording_.calibration.depth;
  const Camera& color = *recording_.calibration.color;
  return fmt::format("{}, {} frames, depth {}x{}, colour {}x{}", recording_.format, size(), depth.width, depth.height,
                     color.width, color.height);
}

std::optional<Pose> FileDataset::pose(std::size_t position) const {
  PANOPTIC_ASSERT(position < size());
  const FileFrame& frame = recording_.frames[position];
  if (!frame.problem.empty()) return std::nullopt;
  try {
    const Eigen::Matrix4d pose = read_pose(recording_, frame);
    return check_pose(pose).used ? std::optional(camera_pose(pose, recording_.calibration)) : std::nullopt;
  } catch (const Unusable&) {
    return std::nullopt;  // `read` says why
  }
}

ReadResult FileDataset::read(std::size_t position) const {
  PANOPTIC_ASSERT(position < size());
  const FileFrame& frame = recording_.frames[position];
  if (!frame.problem.empty()) return skipped(frame.number, frame.problem);
  try {
    RawFrame raw{frame.number, frame.time_s, read_pose(recording_, frame), {}, {}};
    // Before the costly decoding.
    if (const Outcome outcome = check_pose(raw.pose); !outcome.used) return skipped(frame.number, outcome.reason);
    raw.depth = read_depth(recording_, frame);
    raw.color = read_color(recording_, frame);
    return finish(std::move(raw), recording_.calibration);
  } catch (const Unusable& e) {
    return skipped(frame.number, e.reason);
  }
}

}  // namespace panoptic
