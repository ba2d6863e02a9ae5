// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/sens_writer.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "panoptic/base/image_io.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::uint32_t kVersion = 4;
constexpr std::string_view kSensorName = "PanopticFusion simulation";
constexpr float kMillimetres = 1000;

template <typename T>
std::string_view bytes_of(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

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

std::vector<std::uint8_t> deflate_depth(const ImageView<float>& depth) {
  constexpr float kMost = 65535;
  const auto in_millimetres = [](float z) {
    const float mm = z * kMillimetres + 0.5F;
    return mm >= 1 && mm < kMost + 1 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
  };
  Image<std::uint16_t> raw(depth.width(), depth.height());
  for (int v = 0; v < depth.height(); ++v) std::transform(depth.row(v), depth.row(v) + depth.width(), raw.row(v), in_millimetres);
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

SensWriter::SensWriter(std::filesystem::path path, const Camera& camera) : file_(std::move(path)) {
  std::string head;
  const auto put = [&head](const auto& value) { head += bytes_of(value); };
  put(kVersion);
  put(std::uint64_t{kSensorName.size()});
  head += kSensorName;
  const Matrix16 identity = row_major(Eigen::Matrix4d::Identity());
  for (const Matrix16& matrix : {intrinsic(camera), identity, intrinsic(camera), identity}) put(matrix);
  put(ColorCompression::kJpeg);
  put(DepthCompression::kZlib);
  for (const int side : {camera.width, camera.height, camera.width, camera.height}) put(static_cast<std::uint32_t>(side));
  put(kMillimetres);
  count_at_ = head.size();
  put(std::uint64_t{0});
  file_.append(head);
}

void SensWriter::write(const SensFrame& frame) {
  file_.append(bytes_of(frame.header));
  for (const auto* blob : {&frame.color, &frame.depth}) {
    file_.append({reinterpret_cast<const char*>(blob->data()), blob->size()});
  }
  ++frames_;
}

void SensWriter::finish() {
  constexpr std::uint64_t kAccelerationRecords = 0;
  file_.append(bytes_of(kAccelerationRecords));
  file_.overwrite(count_at_, bytes_of(frames_));
  file_.commit();
}

}  // namespace panoptic
