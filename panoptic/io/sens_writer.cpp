// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/sens_writer.h"

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "panoptic/base/error.h"
#include "panoptic/base/image_io.h"

namespace panoptic {
namespace {

constexpr std::uint32_t kVersion = 4;
constexpr std::string_view kSensorName = "PanopticFusion simulation";
constexpr float kMillimetres = 1000;

Matrix16 row_major(const Eigen::Matrix4d& matrix) {
  Matrix16 numbers;
  Eigen::Map<Eigen::Matrix<float, 4, 4, Eigen::RowMajor>>(numbers.data()) = matrix.cast<float>();
  return numbers;
}

Matrix16 intrinsic(const Camera& camera) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = camera.fx;
  matrix(1, 1) = camera.fy;
  matrix(0, 2) = camera.cx;
  matrix(1, 2) = camera.cy;
  return row_major(matrix);
}

std::vector<std::uint8_t> deflate_depth(const Image<float>& depth) {
  constexpr float kMost = 65535;
  std::vector<std::uint16_t> raw(depth.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const float mm = depth[i] * kMillimetres + 0.5F;
    raw[i] = mm >= 1 && mm < kMost + 1 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
  }
  const auto size = static_cast<uLong>(raw.size() * sizeof(std::uint16_t));
  uLongf packed = ::compressBound(size);
  std::vector<std::uint8_t> blob(packed);
  // the fastest level: the others cost several times as much and save little on noisy depth
  const int status = ::compress2(blob.data(), &packed, reinterpret_cast<const Bytef*>(raw.data()), size, Z_BEST_SPEED);
  if (status != Z_OK) throw Error(fmt::format("zlib cannot compress a depth image (status {})", status));
  blob.resize(packed);
  return blob;
}

}  // namespace

SensFrame encode_sens_frame(const Frame& frame, int jpeg_quality) {
  constexpr double kMicro = 1e6;
  PANOPTIC_ASSERT(frame.time_s >= 0 && frame.depth_camera == frame.color_camera);
  SensFrame encoded;
  encoded.color = encode_jpeg(frame.color, jpeg_quality);
  encoded.depth = deflate_depth(frame.depth);
  encoded.header.pose = row_major(frame.world_from_camera.matrix());
  encoded.header.color_time_us = encoded.header.depth_time_us = static_cast<std::uint64_t>(std::llround(frame.time_s * kMicro));
  encoded.header.color_bytes = encoded.color.size();
  encoded.header.depth_bytes = encoded.depth.size();
  return encoded;
}

SensWriter::SensWriter(std::filesystem::path path, const Camera& camera)
    : path_(std::move(path)),
      partial_(path_.parent_path() / fmt::format(".{}.{}.partial", path_.filename().string(), ::getpid())),
      file_(partial_, std::ios::binary | std::ios::trunc) {
  if (!file_) fail(errno);
  const auto put_value = [this](const auto& value) { put(&value, sizeof(value)); };
  put_value(kVersion);
  put_value(std::uint64_t{kSensorName.size()});
  put(kSensorName.data(), kSensorName.size());
  const Matrix16 identity = row_major(Eigen::Matrix4d::Identity());
  for (const Matrix16& matrix : {intrinsic(camera), identity, intrinsic(camera), identity}) put_value(matrix);
  put_value(ColorCompression::kJpeg);
  put_value(DepthCompression::kZlib);
  for (const int side : {camera.width, camera.height, camera.width, camera.height}) put_value(static_cast<std::uint32_t>(side));
  put_value(kMillimetres);
  count_at_ = file_.tellp();
  put_value(std::uint64_t{0});
}

SensWriter::~SensWriter() {
  if (finished_) return;
  file_.close();
  ::unlink(partial_.c_str());
}

void SensWriter::write(const SensFrame& frame) {
  put(&frame.header, sizeof(frame.header));
  put(frame.color.data(), frame.color.size());
  put(frame.depth.data(), frame.depth.size());
  ++frames_;
}

void SensWriter::finish() {
  constexpr std::uint64_t kAccelerationRecords = 0;
  put(&kAccelerationRecords, sizeof(kAccelerationRecords));
  file_.seekp(count_at_);
  put(&frames_, sizeof(frames_));
  errno = 0;
  file_.close();
  if (!file_ || ::rename(partial_.c_str(), path_.c_str()) != 0) fail(errno);
  finished_ = true;
}

void SensWriter::put(const void* bytes, std::size_t count) {
  errno = 0;
  file_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count));
  if (!file_) fail(errno);
}

void SensWriter::fail(int error) {
  file_.close();
  ::unlink(partial_.c_str());
  throw Error(fmt::format("cannot write {}: {}; free space or choose another folder", path_.string(),
                          error != 0 ? std::strerror(error) : "the disk takes no more"));
}

}  // namespace panoptic
