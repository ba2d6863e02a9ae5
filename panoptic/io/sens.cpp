// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/sens.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_frame.h"
#include "panoptic/io/dataset_text.h"
#include "panoptic/io/sens_file.h"

namespace panoptic {
namespace {

constexpr double kAssumedRate_hz = 30;

Eigen::Matrix4d to_double(const Matrix16& numbers) {
  return Eigen::Map<const Eigen::Matrix<float, 4, 4, Eigen::RowMajor>>(numbers.data()).cast<double>();
}

Camera camera_of(const Matrix16& matrix, std::uint32_t width, std::uint32_t height, const std::string& source) {
  const std::vector<double> numbers(matrix.begin(), matrix.end());
  Camera camera = to_camera(numbers, source);
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  return camera;
}

Pose extrinsic_of(const Matrix16& matrix, const std::string& source) {
  if (const Outcome pose = check_pose(to_double(matrix)); !pose.used) throw Error(fmt::format("{}: {}", source, pose.reason));
  return rigid(to_double(matrix));
}

// Inflates to exactly `out.size()` pixels and no byte more, so that a bomb costs nothing.
// REQUIRES could_inflate_to(blob.size(), the bytes of `out`), so that a small file does not ask for much memory.
bool inflate_exactly(std::span<const std::uint8_t> blob, Image<std::uint16_t>& out) {
  const uLong expected = static_cast<uLong>(out.size() * sizeof(std::uint16_t));
  uLongf written = expected;
  const int status = ::uncompress(reinterpret_cast<Bytef*>(out.data()), &written, blob.data(), static_cast<uLong>(blob.size()));
  return status == Z_OK && written == expected;
}

bool could_inflate_to(std::uint64_t blob_bytes, std::uint64_t bytes) {
  constexpr std::uint64_t kDeflateRatio = 1032;  // 258 bytes from two bits
  return bytes <= blob_bytes * kDeflateRatio;
}

Calibration calibration_of(const StreamHeader& h, const std::string& name) {
  Calibration calibration;
  calibration.depth = camera_of(h.depth_intrinsic, h.depth_width, h.depth_height, name + ": depth intrinsics");
  calibration.color = camera_of(h.color_intrinsic, h.color_width, h.color_height, name + ": colour intrinsics");
  const Pose common_from_color = extrinsic_of(h.color_extrinsic, name + ": colour extrinsics");
  calibration.posed_from_depth = extrinsic_of(h.depth_extrinsic, name + ": depth extrinsics");
  calibration.color_from_depth = common_from_color.inverse() * calibration.posed_from_depth;
  calibration.depth_scale = static_cast<double>(h.depth_shift);
  return calibration;
}

std::optional<Image<Rgb>> decode_color(std::span<const std::uint8_t> blob, const StreamHeader& h) {
  if (h.color_compression != ColorCompression::kRaw) {
    try {
      return decode_rgb(blob, "colour image");
    } catch (const Error&) {
      return std::nullopt;
    }
  }
  static_assert(sizeof(Rgb) == 3);
  if (blob.size() != std::uint64_t{h.color_width} * h.color_height * sizeof(Rgb)) return std::nullopt;
  Image<Rgb> image(static_cast<int>(h.color_width), static_cast<int>(h.color_height));
  std::memcpy(image.data(), blob.data(), blob.size());
  return image;
}

std::optional<Image<std::uint16_t>> decode_depth(std::span<const std::uint8_t> blob, const StreamHeader& h) {
  const bool is_packed = h.depth_compression == DepthCompression::kZlib;
  const std::uint64_t bytes = std::uint64_t{h.depth_width} * h.depth_height * sizeof(std::uint16_t);
  if (is_packed ? !could_inflate_to(blob.size(), bytes) : blob.size() != bytes) return std::nullopt;
  Image<std::uint16_t> image(static_cast<int>(h.depth_width), static_cast<int>(h.depth_height));
  if (is_packed) return inflate_exactly(blob, image) ? std::optional(std::move(image)) : std::nullopt;
  std::memcpy(image.data(), blob.data(), blob.size());
  return image;
}

}  // namespace

struct SensDataset::State {
  explicit State(const std::filesystem::path& path) : file(path) {}

  SensFile file;
  SensIndex index;
  Calibration calibration;  // fitted
  bool without_poses = false;

  Eigen::Matrix4d pose_of(const FrameHeader& frame) const {
    return without_poses ? Eigen::Matrix4d(Eigen::Matrix4d::Identity()) : to_double(frame.pose);
  }
};

SensDataset::SensDataset(const std::filesystem::path& path, const std::filesystem::path& calibration, bool without_poses)
    : state_(std::make_unique<State>(path)) {
  state_->without_poses = without_poses;
  const std::string& name = state_->file.name();
  state_->index = read_sens_index(state_->file);
  const StreamHeader& h = state_->index.header;
  state_->calibration = calibration_of(h, name);
  if (!calibration.empty()) read_calibration(calibration, state_->calibration);
  state_->calibration = fitted(state_->calibration, {static_cast<int>(h.depth_width), static_cast<int>(h.depth_height)},
                               {static_cast<int>(h.color_width), static_cast<int>(h.color_height)}, name);
}

SensDataset::~SensDataset() = default;

std::size_t SensDataset::size() const { return state_->index.frame_offsets.size(); }

std::string SensDataset::description() const {
  const StreamHeader& h = state_->index.header;
  return fmt::format("ScanNet .sens, {} frames, depth {}x{}, colour {}x{}", size(), h.depth_width, h.depth_height, h.color_width,
                     h.color_height);
}

ReadResult SensDataset::read(std::size_t position) const {
  PANOPTIC_ASSERT(position < size());
  try {
    return read_frame(position);
  } catch (const FileError& e) {
    return skipped(static_cast<std::int64_t>(position), fmt::format("frame unreadable: {}", e.what()));
  }
}

std::optional<Pose> SensDataset::pose(std::size_t position) const {
  PANOPTIC_ASSERT(position < size());
  try {
    FrameHeader frame;
    if (!state_->file.read(state_->index.frame_offsets[position], &frame, sizeof(frame))) return std::nullopt;
    const Eigen::Matrix4d pose = state_->pose_of(frame);
    return check_pose(pose).used ? std::optional(camera_pose(pose, state_->calibration)) : std::nullopt;
  } catch (const FileError&) {
    return std::nullopt;  // `read` says why
  }
}

RecordingNotes SensDataset::notes() const { return {{}, {}, state_->calibration.depth_scale}; }

ReadResult SensDataset::read_frame(std::size_t position) const {
  constexpr double kMicro = 1e-6;
  const auto number = static_cast<std::int64_t>(position);
  const SensFile& file = state_->file;
  const std::uint64_t offset = state_->index.frame_offsets[position];
  FrameHeader frame;
  if (!file.read(offset, &frame, sizeof(frame))) return skipped(number, "frame header unreadable");
  if (frame.color_bytes > kMaxSensBlobBytes || frame.depth_bytes > kMaxSensBlobBytes)
    return skipped(number, "the file changed while in use");
  RawFrame raw{number, static_cast<double>(frame.depth_time_us) * kMicro, state_->pose_of(frame), {}, {}};
  if (frame.depth_time_us == 0) raw.time_s = static_cast<double>(number) / kAssumedRate_hz;
  // Before the costly decoding.
  if (const Outcome outcome = check_pose(raw.pose); !outcome.used) return skipped(number, outcome.reason);

  const auto color_blob = file.read(offset + sizeof(frame), frame.color_bytes);
  const auto depth_blob = file.read(offset + sizeof(frame) + frame.color_bytes, frame.depth_bytes);
  if (!color_blob || !depth_blob) return skipped(number, "frame unreadable: the file ends before it");
  const auto depth = decode_depth(*depth_blob, state_->index.header);
  if (!depth) return skipped(number, "depth image unreadable: its bytes do not make up the size in the header");
  auto color = decode_color(*color_blob, state_->index.header);
  if (!color) return skipped(number, "colour image unreadable");
  raw.depth = to_metres(*depth, state_->calibration);
  raw.color = std::move(*color);
  return finish(std::move(raw), state_->calibration);
}

}  // namespace panoptic
