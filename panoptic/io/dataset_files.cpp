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
#include "panoptic/base/image_header.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_confidence.h"
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

// Depth without the readings that are too unsure, and the weights of the others.
struct WeighedDepth {
  Image<float> depth;
  Image<float> weight;
};

WeighedDepth read_weighed_depth(const FileRecording& recording, const FileFrame& frame) {
  WeighedDepth read{read_depth(recording, frame), {}};
  if (!recording.has_confidence) return read;
  if (frame.confidence.empty()) throw Unusable{"confidence image missing"};
  const Outcome outcome = weigh_by_confidence(recording.root, frame.confidence, read.depth, read.weight);
  if (!outcome.used) throw Unusable{outcome.reason};
  return read;
}

Image<Rgb> read_color(const FileRecording& recording, const FileFrame& frame) {
  return read_image(recording, frame.color, "colour", [&](const std::filesystem::path& path) {
    return frame.video_image ? recording.video->read(*frame.video_image) : read_rgb(path);
  });
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

bool is_one_channel_of_16_bits(const std::filesystem::path& path) {
  if (!is_file(path)) return false;
  const std::string bytes = read_file(path);
  const SampleKind kind = sample_kind({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  return kind.channels == 1 && kind.bits == 16;
}

[[noreturn]] void refuse_recording(const FileRecording& recording, const std::string& first_reason) {
  const FileFrame* first = recording.frames.empty() ? nullptr : &recording.frames.front();
  if (first != nullptr && !first->color.empty() && !first->video_image &&
      is_one_channel_of_16_bits(recording.root / first->color)) {
    throw Error(
        fmt::format("{}: {} recording whose colour and depth are swapped: {} has one channel of 16 bits, as depth has, and {} is "
                    "no depth image ({}); swap the folders or columns",
                    recording.root.string(), recording.format, first->color, first->depth, first_reason));
  }
  throw Error(
      fmt::format("{}: {} recording without one usable pair of images (first frame: {}); check that it was unpacked whole",
                  recording.root.string(), recording.format, first_reason));
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
  refuse_recording(recording, first_reason);
}

// An image of one kind, of the size that most of a few frames spread over the recording have: the first may be of another.
template <typename Read>
auto usual_image(const FileRecording& recording, const Read& read) {
  constexpr std::size_t kSample = 5;
  const std::size_t count = recording.frames.size();
  std::vector<decltype(read(recording, FileFrame{}))> images;
  for (std::size_t i = 0; i < std::min(kSample, count); ++i) {
    try {
      images.push_back(read(recording, recording.frames[i * count / std::min(kSample, count)]));
    } catch (const Unusable&) {  // the frames that cannot be read are told when they are
    }
  }
  if (images.empty()) return first_image(recording, read);
  const auto as_large = [&](const auto& image) {
    return std::count_if(images.begin(), images.end(), [&](const auto& other) { return size_of(other) == size_of(image); });
  };
  return std::move(
      *std::max_element(images.begin(), images.end(), [&](const auto& a, const auto& b) { return as_large(a) < as_large(b); }));
}

std::size_t readings_in(const Image<float>& depth) {
  return static_cast<std::size_t>(std::count_if(depth.data(), depth.data() + depth.size(), [](float z) { return z > 0; }));
}

// The share of the readings that are left out for their confidence, in a few frames spread over the recording.
std::optional<std::string> unsure_readings(const FileRecording& recording) {
  constexpr std::size_t kSample = 20;
  constexpr double kPercent = 100;
  const std::size_t count = recording.frames.size();
  std::size_t frames = 0;
  std::size_t all = 0;
  std::size_t used = 0;
  for (std::size_t i = 0; recording.has_confidence && i < std::min(kSample, count); ++i) {
    const FileFrame& frame = recording.frames[i * count / std::min(kSample, count)];
    try {
      const Image<float> sure = read_weighed_depth(recording, frame).depth;
      all += readings_in(read_depth(recording, frame));
      used += readings_in(sure);
      ++frames;
    } catch (const Unusable&) {  // told when the frame is read
    }
  }
  if (all == 0) return std::nullopt;
  return fmt::format("{:.1f} % of the depth readings, whose confidence is the lowest (in {} images looked at)",
                     kPercent * static_cast<double>(all - used) / static_cast<double>(all), frames);
}

RecordingNotes notes_of(const FileRecording& recording) {
  const Calibration& c = recording.calibration;
  RecordingNotes notes{recording.assumed, files_left_out(recording), c.depth_scale};
  if (auto unsure = unsure_readings(recording)) notes.left_out.push_back(std::move(*unsure));
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
  const DepthImage depth = usual_image(recording_, read_raw_depth);
  const Video* video = recording_.video.get();
  const ImageSize color =
      video != nullptr ? ImageSize{video->width(), video->height()} : size_of(usual_image(recording_, read_color));
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
    WeighedDepth depth = read_weighed_depth(recording_, frame);
    raw.depth = std::move(depth.depth);
    raw.depth_weight = std::move(depth.weight);
    raw.color = read_color(recording_, frame);
    if (!frame.camera) return finish(std::move(raw), recording_.calibration);
    return finish(std::move(raw), with_camera(recording_.calibration, *frame.camera, frame.depth));
  } catch (const Unusable& e) {
    return skipped(frame.number, e.reason);
  } catch (const Error& e) {  // intrinsics of another shape
    return skipped(frame.number, e.what());
  }
}

}  // namespace panoptic
